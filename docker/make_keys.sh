#!/bin/sh
# Makes keys for both sites and lets each trust the other; keys that are there already stay as they are.
set -eu
for site in remote operator; do
    [ -e "/keys/$site/site.key_secret" ] || python -m teletaction keys init --keys "/keys/$site"
done
own() { python -m teletaction keys show --keys "/keys/$1" | awk '$1 == "own" { print $3 }'; }
python -m teletaction keys trust operator "$(own operator)" --keys /keys/remote
python -m teletaction keys trust remote "$(own remote)" --keys /keys/operator
