#!/bin/sh
# Makes the files of a console beyond loopback in the folder $1: a certificate for the host named $2 (and for localhost), and
# two tokens, one to act and one to observe. Existing files stay.
set -eu
umask 077
cd "$1"
case "$2" in
    *:*) host="IP:$2" ;;
    *[!0-9.]*) host="DNS:$2" ;;
    *) host="IP:$2" ;;
esac
if [ ! -e certificate.pem ] && [ ! -e key.pem ]; then
    said=$(openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -days 825 -subj "/CN=$2" \
        -addext "subjectAltName=$host,DNS:localhost,IP:127.0.0.1" -keyout key.part -out certificate.part 2>&1) ||
        { echo "$said" >&2; exit 1; }
    mv key.part key.pem
    mv certificate.part certificate.pem
fi
[ ! -e tokens ] || exit 0
printf 'console act %s\nobserver observe %s\n' "$(openssl rand -hex 32)" "$(openssl rand -hex 32)" > tokens.part
mv tokens.part tokens
