#!/usr/bin/env bash
# Makes sure that packets between two network namespaces can be delayed and lost, packet by packet.
#
#     eval "$(tests/network/prepare.sh)"
#
# prints IMPAIRMENT_PYTHON: an interpreter that has NetfilterQueue, in an environment of its own, since that package needs a
# compiler and nothing else here does. What is missing is installed where this is root on Debian. Exit code 1, and one line on
# stderr that says why, when there is no way.
set -euo pipefail

state=${NETWORK_STATE:-/var/tmp/teletaction-network}
give_up() { echo "no impaired packets: $*" >&2; exit 1; }
installed() { dpkg-query -W -f '${Status}' "$1" 2>/dev/null | grep -q '^install ok installed$'; }

[ "$(uname -s)" = Linux ] && [ "$(id -u)" = 0 ] || give_up "only root on Linux can make network namespaces"
mkdir -p "$state"

python=$state/venv/bin/python
if ! "$python" -c 'import netfilterqueue' 2>/dev/null; then
    base=${PYTHON:-python3}
    if command -v apt-get >/dev/null; then
        missing=()
        for package in libnetfilter-queue-dev iptables iproute2 util-linux gcc libc6-dev; do
            installed "$package" || missing+=("$package")
        done
        # Python's own headers, when this Python is Debian's and came without them.
        headers=$("$base" -c 'import sysconfig; print(sysconfig.get_paths()["include"])')
        [ -f "$headers/Python.h" ] || missing+=(python3-dev)
        if [ ${#missing[@]} -gt 0 ]; then
            echo "prepare.sh: installing ${missing[*]}" >&2
            export DEBIAN_FRONTEND=noninteractive
            { apt-get update -qq && apt-get install -qq -y --no-install-recommends "${missing[@]}"; } >"$state/apt.log" 2>&1 ||
                give_up "apt-get could not install ${missing[*]} (see $state/apt.log)"
        fi
    fi
    { "$base" -m venv "$state/venv" && "$state/venv/bin/pip" install --quiet NetfilterQueue==1.1.0; } >"$state/pip.log" 2>&1 ||
        give_up "NetfilterQueue could not be built (see $state/pip.log)"
fi

unshare --net sh -c 'ip link set lo up && iptables -A INPUT -j NFQUEUE --queue-num 1' >"$state/probe.log" 2>&1 ||
    give_up "this kernel gives no namespaces or no packet queue (see $state/probe.log)"

echo "export IMPAIRMENT_PYTHON=$(printf %q "$python")"
