#!/bin/sh
# Makes the files of a console beyond loopback in the folder $1: a certificate for the host named $2 (and for localhost), and
# two tokens, one to act and one to observe. Existing tokens stay, and so does their certificate.
set -eu
umask 077
cd "$1"
[ ! -e tokens ] || exit 0
openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -days 825 -subj "/CN=$2" \
    -addext "subjectAltName=DNS:$2,DNS:localhost,IP:127.0.0.1" -keyout key.pem -out certificate.pem 2>/dev/null
printf 'console act %s\nobserver observe %s\n' "$(openssl rand -hex 32)" "$(openssl rand -hex 32)" > tokens.part
mv tokens.part tokens
