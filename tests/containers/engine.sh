#!/usr/bin/env bash
# Makes sure that a container engine answers and that the image python:3.11-slim is there.
#
#     eval "$(tests/containers/engine.sh)"
#
# prints the DOCKER_HOST and PATH to use, and ENGINE_PID when it had to start an engine itself. Where no engine runs it needs
# root and apt-get; where no registry can be reached it builds a stand-in of the base image from Debian's packages.
# Exit code 1, and one line on stderr that says why, when there is no way.
set -euo pipefail

state=${ENGINE_STATE:-/var/tmp/teletaction-engine}
compose_needed() { ! docker compose version >/dev/null 2>&1 && ! command -v docker-compose >/dev/null; }
answers() { command -v docker >/dev/null && timeout 20 docker version >/dev/null 2>&1; }
give_up() { echo "no containers: $*" >&2; exit 1; }
install() {
    [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null || give_up "$* missing, and this is no root on Debian to install it"
    echo "engine.sh: installing $*" >&2
    export DEBIAN_FRONTEND=noninteractive
    { apt-get update -qq && apt-get install -qq -y --no-install-recommends "$@"; } >"$state/apt.log" 2>&1 ||
        give_up "apt-get could not install $* (see $state/apt.log)"
}

# Debian's own client first: a client newer than its engine may lack the builder that the engine has.
export PATH=/usr/bin:$PATH
engine_pid=
if ! answers; then
    mkdir -p "$state"
    export DOCKER_HOST=unix://$state/docker.sock
fi
if ! answers; then
    command -v dockerd >/dev/null || install docker.io iptables
    [ "$(id -u)" = 0 ] || give_up "no engine answers, and only root can start one"
    rm -f "$state/docker.pid"
    setsid dockerd --host "$DOCKER_HOST" --data-root "$state/data" --exec-root "$state/run" \
        --pidfile "$state/docker.pid" </dev/null >"$state/dockerd.log" 2>&1 &
    for _ in $(seq 100); do answers && break; sleep 0.3; done
    answers || give_up "the engine did not start (see $state/dockerd.log)"
    engine_pid=$(cat "$state/docker.pid")
fi
mkdir -p "$state"
if compose_needed; then install docker-compose; fi

base=python:3.11-slim
if ! docker image inspect "$base" >/dev/null 2>&1 && ! timeout 120 docker pull --quiet "$base" >/dev/null 2>&1; then
    command -v mmdebstrap >/dev/null || install mmdebstrap
    echo "engine.sh: no registry answers; building a stand-in of $base" >&2
    # pip may install system-wide there, as in the real image, and trusts and asks what this machine trusts and asks.
    mmdebstrap --quiet --variant=minbase --include=python3,python3-pip,python3-venv,ca-certificates \
        --dpkgopt='path-exclude=/usr/share/man/*' --dpkgopt='path-exclude=/usr/share/doc/*' \
        --customize-hook='rm -f "$1"/usr/lib/python3*/EXTERNALLY-MANAGED' \
        --customize-hook='ln -s ../../bin/python3 "$1/usr/local/bin/python"; ln -s ../../bin/pip3 "$1/usr/local/bin/pip"' \
        --customize-hook='mkdir -p "$1/usr/local/share/ca-certificates"
            find /usr/local/share/ca-certificates -name "*.crt" -exec cp {} "$1/usr/local/share/ca-certificates/" \;
            chroot "$1" update-ca-certificates >/dev/null 2>&1
            if [ -f /etc/pip.conf ]; then cp /etc/pip.conf "$1/etc/pip.conf"; fi' \
        bookworm - 2>"$state/base.log" |
        docker import --change 'CMD ["python3"]' - "$base" >/dev/null ||
        give_up "the base image could neither be pulled nor built (see $state/base.log)"
fi

echo "export PATH=$(printf %q "$PATH") ${DOCKER_HOST:+DOCKER_HOST=$(printf %q "$DOCKER_HOST")} ENGINE_PID=$engine_pid"
