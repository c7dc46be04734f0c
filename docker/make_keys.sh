#!/bin/sh
# Makes keys for both sites and lets each trust the other; and for the console's page a certificate and two tokens, one to
# act with and one to look on with. What is there already stays as it is.
set -eu
for site in remote operator; do
    [ -e "/keys/$site/site.key_secret" ] || python -m teletaction keys init --keys "/keys/$site"
done
own() { python -m teletaction keys show --keys "/keys/$1" | awk '$1 == "own" { print $3 }'; }
# After the two dashes, since a key may begin with one.
python -m teletaction keys trust --keys /keys/remote -- operator "$(own operator)"
python -m teletaction keys trust --keys /keys/operator -- remote "$(own remote)"

umask 077
cd /keys/console
[ -e tokens ] || {
    openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -days 825 -subj /CN=localhost \
        -addext subjectAltName=DNS:localhost,IP:127.0.0.1 -keyout key.pem -out certificate.pem 2>/dev/null
    printf 'console act %s\nobserver observe %s\n' "$(openssl rand -hex 32)" "$(openssl rand -hex 32)" > tokens.part
    mv tokens.part tokens
}
