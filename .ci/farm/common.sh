# Shared by the farm scripts: hosts made of namespaces, a shared folder, waiting, comparing and cleaning up.
# Sourced by bash with the name of the engine.
set -Eeuo pipefail
trap 'echo "${BASH_SOURCE[0]}: line $LINENO: $BASH_COMMAND"' ERR
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
source .ci/steps.sh

engine=$1
work=
# The first process of each host, by the host's number.
inits=()
PATH=$PATH:/usr/sbin:/sbin

skip() {
    echo "NOT checked: $engine: $1"
    exit 0
}

# need COMMAND PACKAGE: installs it, or ends the script.
need() {
    apt_install "$1" "$2"
    command -v "$1" >/dev/null || skip "$1 is missing"
}

# Ends all hosts, and with them their processes, mounts and networks.
clean() {
    local status=$? n
    trap - EXIT INT TERM HUP ERR
    for n in "${!inits[@]}"; do power_off "$n"; done
    if [ -n "$work" ]; then
        if [ "$status" != 0 ]; then
            tail -n 30 "$work"/*.log "$work"/*/*.log "$work"/*/*/*.log 2>/dev/null || true
            echo "$engine: failed with $status"
        fi
        rm -rf "$work"
    fi
    exit "$status"
}

# A temporary folder, with octray on the PATH and the shipped scenes in `$shared`, which all hosts see and whose name has a
# space.
start() {
    if [ "$(id -u)" != 0 ] || ! unshare --net --mount --uts --pid --fork true 2>/dev/null; then
        skip "hosts are namespaces, which this user may not make"
    fi
    trap clean EXIT
    trap 'exit 130' INT TERM HUP
    work=$(mktemp -d)
    shared="$work/shared disk"
    mkdir "$work/bin" "$shared"
    cargo build --quiet --release
    cp "${CARGO_TARGET_DIR:-target}/release/octray" "$work/bin"
    cp -r scenes "$shared"
    PATH=$work/bin:$PATH
    cd "$shared"
}

# host N: starts a host named nodeN with its own processes, mounts and network. Host 0 has the bridge and comes first. The
# networks have no way out. If the script is killed, its hosts are, too.
host() {
    local n=$1 parent init
    printf '127.0.0.1 localhost\n' >"$work/hosts"
    printf '10.77.0.%d node%d\n' 100 0 1 1 2 2 3 3 4 4 >>"$work/hosts"
    rm -f "$work/up"
    setpriv --pdeathsig KILL unshare --net --mount --uts --pid --fork --kill-child --mount-proc bash -c '
        hostname "node$0"
        ip link set lo up
        mount --bind "$1/hosts" /etc/hosts
        mount -t tmpfs none /run
        mkdir /run/sshd
        touch "$1/up"
        while :; do sleep 1000 & wait; done' "$n" "$work" >"$work/node$n.log" 2>&1 &
    parent=$!
    disown
    wait_for 10 "host $n" test -e "$work/up"
    init=$(pgrep -P "$parent")
    inits[n]=$init
    if [ "$n" = 0 ]; then
        on 0 sh -c 'ip link add name bridge type bridge; ip link set bridge up; ip addr add 10.77.0.100/24 dev bridge'
    else
        # The link of a host that was switched off takes a moment to disappear.
        wait_for 10 "the network of host $n" \
            nsenter -t "${inits[0]}" --net ip link add "host$n" type veth peer name eth0 netns "$init"
        on 0 sh -c "ip link set host$n master bridge up"
        on "$n" sh -c "ip addr add 10.77.0.$n/24 dev eth0; ip link set eth0 up"
    fi
}

# on N COMMAND...: runs it on a host, in the current folder.
on() {
    local n=$1
    shift
    nsenter -t "${inits[n]}" --net --mount --uts --pid -- sh -c 'cd "$0" && exec "$@"' "$PWD" "$@"
}

# power_off N: kills all processes of a host and removes its network.
power_off() {
    local init=${inits[$1]}
    unset "inits[$1]"
    kill -9 "$init" 2>/dev/null || true
    while kill -0 "$init" 2>/dev/null; do sleep 0.01; done
}

# fill N FOLDER: mounts a disk with 4 kB of free space over FOLDER on host N: enough for the beginning of any picture.
fill() {
    on "$1" mount -t tmpfs -o size=16k full "$2"
    on "$1" sh -c 'head -c 12288 /dev/zero >"$0/other"' "$2"
}

# make_room N FOLDER: undoes `fill`, and checks that nothing was left on the full disk.
make_room() {
    [ "$(on "$1" ls -A "$2")" = other ]
    on "$1" umount "$2"
}

# wait_for SECONDS WHAT COMMAND...: waits until the command succeeds.
wait_for() {
    local end=$((SECONDS + $1)) what=$2
    shift 2
    until "$@" >/dev/null 2>&1; do
        if [ "$SECONDS" -ge "$end" ]; then
            echo "$engine: $what: still not there"
            return 1
        fi
        sleep 0.05
    done
}

# has COUNT PATTERN: whether at least COUNT files match.
has() {
    [ "$(compgen -G "$2" | wc -l)" -ge "$1" ]
}

# works N: whether octray is running on host N.
works() {
    on "$1" pgrep -x octray
}

# fails WHAT COMMAND...: checks that the command fails.
fails() {
    local what=$1 status=0
    shift
    "$@" || status=$?
    if [ "$status" = 0 ]; then
        echo "$engine: $what: did not fail"
        return 1
    fi
    say "$what: exit code $status"
}

say() {
    printf '%s: %s (%d s)\n' "$engine" "$1" "$SECONDS"
}

# same WHOLE MADE: checks that two pictures, or two folders of pictures, are identical.
same() {
    diff -r "$1" "$2"
    say "$2 ($(find "$2" -type f | wc -l)) has the bytes of one machine"
}

# no_litter FOLDER: checks that killed tasks left no temporary files.
no_litter() {
    if find "$1" -name '.octray-*' | grep .; then
        echo "$engine: temporary files are left"
        return 1
    fi
}
