#!/usr/bin/env bash
# The component on LinuxCNC without hardware: called cycle by cycle in halrun, then a program in LinuxCNC's simulator, both held against
# kinetostat. Needs root and Debian: installs linuxcnc-uspace and linuxcnc-uspace-dev if they are missing, puts its modules where LinuxCNC
# looks for them and takes them away again. LinuxCNC itself runs as nobody. Takes two minutes once everything is built and installed.
# KINETOSTAT: the program to ask; GENERATED: a folder made by its export-realtime for the Orthoglide with test/process.toml.
set -euo pipefail
[ -z "${KINETOSTAT:-}" ] || KINETOSTAT=$(realpath "$KINETOSTAT")
[ -z "${GENERATED:-}" ] || GENERATED=$(realpath "$GENERATED")
cd "$(dirname "$0")"
modules=/usr/lib/linuxcnc/modules
made=(kinetostat_kins kinetostat_probe)
fail() {
    echo "linuxcnc/test.sh: $1" >&2
    exit 1
}
[ "$(id -u)" = 0 ] || fail "must be run as root: it installs packages and modules"
if ! command -v halcompile >/dev/null || ! command -v linuxcnc >/dev/null; then
    apt-get update -qq
    DEBIAN_FRONTEND=noninteractive apt-get install -qq -y --no-install-recommends linuxcnc-uspace linuxcnc-uspace-dev >/dev/null
fi
for module in "${made[@]}"; do
    [ ! -e "$modules/$module.so" ] || fail "$modules/$module.so is there already; remove it first"
done
out=$(mktemp -d)
clean() {
    for module in "${made[@]}"; do rm -f "$modules/$module.so"; done
    rm -rf "$out"
}
trap clean EXIT

# The program, the functions it generates for the Orthoglide, and the modules.
if [ -z "${KINETOSTAT:-}" ]; then
    cargo build --quiet --all-features --manifest-path ../Cargo.toml
    target=${CARGO_TARGET_DIR:-../target}
    KINETOSTAT=$(realpath "$target/debug/kinetostat")
fi
if [ -z "${GENERATED:-}" ]; then
    GENERATED=$out/generated
    "$KINETOSTAT" export-realtime --machine orthoglide --process test/process.toml --out "$GENERATED"
fi
library=$GENERATED/target/release/libkinetostat_correction.a
[ -e "$library" ] || cargo build --quiet --release --manifest-path "$GENERATED/Cargo.toml" --target-dir "$GENERATED/target"
cp -r . "$out/package"
cd "$out/package"
# Where LLVM is installed, binutils try to read what Rust leaves for it in the library, and say a line for each object.
{ make -s GENERATED="$GENERATED" LIBRARY="$library" install && (cd test && halcompile --install kinetostat_probe.comp); } \
    >"$out/log" 2>&1 || { cat "$out/log"; fail "the modules cannot be built"; }

# As a user, without a screen.
cp test/calls.* sim/
chown -R nobody:nogroup "$out"
chmod 755 "$out"
as_user() {
    (cd sim && timeout 120 setpriv --reuid=nobody --regid=nogroup --clear-groups env -u DISPLAY HOME="$out/package/sim" "$@") \
        >"$out/log" 2>&1 || { cat "$out/log"; setpriv --reuid=nobody --regid=nogroup --clear-groups halrun -U; fail "$* failed"; }
}
failed=0
mkdir "$out/no_linuxcnc"
echo '#include <math.h>' > "$out/no_linuxcnc/rtapi_math.h"
gcc -O2 -Wall -Werror -I. -I"$GENERATED/include" -I"$out/no_linuxcnc" -o "$out/lost" test/lost.c loaded_kinematics.c "$library" -lm
"$out/lost" || failed=1
as_user halrun -f calls.hal
python3 test/check_calls.py "$KINETOSTAT" test/process.toml sim/calls.csv "$out/calls" || failed=1

as_user linuxcnc -r orthoglide.ini
mv sim/samples.csv sim/loaded.csv
# The same with LinuxCNC's own kinematics, for the time it takes.
sed -i -e 's/kinetostat_kins$/trivkins kinstype=BOTH/' -e '/JOINT_2/,$s/-341/100/' -e 's/-341/0/' \
    -e 's/^MIN_LIMIT = -405/MIN_LIMIT = -1000/' -e 's/^MAX_LIMIT = -155/MAX_LIMIT = 1000/' sim/orthoglide.ini
sed -i '/kinetostat/d' sim/*.hal
as_user linuxcnc -r orthoglide.ini
clocks=$(gcc -O1 -xc -o "$out/clocks" test/clocks.c && "$out/clocks")
python3 test/check_program.py "$KINETOSTAT" test/process.toml sim/loaded.csv sim/samples.csv "$out/program" "$clocks" || failed=1
exit "$failed"
