#!/bin/sh
# Makes keys for both sites and lets each trust the other; keys that are there already stay as they are.
set -eu
for site in remote operator; do
    [ -e "/keys/$site/site.key_secret" ] || python -m teletaction keys init --keys "/keys/$site"
done
own() { python -m teletaction keys show --keys "/keys/$1" | awk '$1 == "own" { print $3 }'; }
# After the two dashes, since a key may begin with one.
python -m teletaction keys trust --keys /keys/remote -- operator "$(own operator)"
python -m teletaction keys trust --keys /keys/operator -- remote "$(own remote)"
