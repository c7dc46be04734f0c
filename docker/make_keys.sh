#!/bin/sh
# Makes keys for both sites of the demonstration, lets each trust the other, and gives its console a certificate and tokens.
# What is there already stays as it is.
set -eu
for site in remote operator; do
    [ -e "/keys/$site/site.key_secret" ] || python -m teletaction keys init --keys "/keys/$site"
done
own() { python -m teletaction keys show --keys "/keys/$1" | awk '$1 == "own" { print $3 }'; }
# After the two dashes, since a key may begin with one.
python -m teletaction keys trust --keys /keys/remote -- operator "$(own operator)"
python -m teletaction keys trust --keys /keys/operator -- remote "$(own remote)"
make_console_access.sh /keys/console localhost
