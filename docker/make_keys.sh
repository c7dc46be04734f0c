#!/bin/sh
# Makes keys for both sites of the demonstration, lets each trust the other, and gives its console a certificate and tokens.
# Existing files stay.
set -eu
for site in remote operator; do
    [ -e "/keys/$site/site.key_secret" ] || python -m teletaction keys init --keys "/keys/$site"
done
own() { python -m teletaction keys show --keys "/keys/$1" | awk '$1 == "own" { print $3 }'; }
# The two dashes end the options, because a key may begin with a dash.
python -m teletaction keys trust --keys /keys/remote -- operator "$(own operator)"
python -m teletaction keys trust --keys /keys/operator -- remote "$(own remote)"
make_console_access.sh /keys/console localhost
