"""The stages of .ci/run, what every change must pass, and of .ci/full, what is run before an issue is called resolved.

    .ci/run  [--list | --table] [STAGE...]
    .ci/full [--list | --table] [--again] [STAGE...]

Stages that do not wait for one another run side by side, as many as there are cores. What a stage prints is in target/ci/STAGE.log and shown if it
fails. --list says what each stage is for, --table prints the seconds of the last run of each as Markdown. .ci/full goes on where it was
interrupted as long as the tree is the same; --again begins anew. A run of .ci/full that has gone through all stages adds a line to .ci/full.log.

Needs Rust, Node with npm, and Python; the rest is fetched. The page stages install Chromium and Firefox, and the LinuxCNC stage LinuxCNC
(Debian, as root), if they are missing.
"""

import argparse
import concurrent.futures
import contextlib
import dataclasses
import datetime
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TARGET = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).resolve()
STATE = TARGET / "ci"
LOG = ".ci/full.log"
# What runs write, and what says what was measured, of which .ci/full runs nothing: draws that failed, planted faults, and the table of seconds.
APART = (LOG, "tests/proptest-regressions", "crates/*/tests/proptest-regressions/*", "fuzz/corpus/*/found_*", ".ci/mutations", ".ci/README.md")
# .ci/full was run at most as many commits ago.
MAX_COMMITS = 150
# Lines that the log keeps.
MAX_LINES = 20


@dataclasses.dataclass
class Stage:
    name: str
    # Why it is there, or, in .ci/full, why not on every change.
    reason: str
    # Bash, run in the root of the project; $OUT is a folder of this run, $PROGRAM the program built by `tests`.
    script: str
    after: tuple = ()
    env: dict = dataclasses.field(default_factory=dict)


# What only looks at code does so beside what builds it.
LINT = {"CARGO_TARGET_DIR": str(TARGET / "lint")}
# What browsers and readers are driven by.
PAGE_TOOLS = """
    python3 -m venv "$TARGET/ci/venv"
    "$TARGET/ci/venv/bin/pip" install --quiet --requirement tests/page/requirements.txt
"""

RUN = [
    Stage("format", "One layout of code; the planted faults apply to it.", """
        # The questions' modules are named in a macro, where cargo does not look for files.
        cargo fmt --all --check -- src/questions/*/mod.rs
        for fault in .ci/mutations/*.patch; do git apply --check "$fault" || { echo "$fault does not apply any more"; exit 1; }; done
    """),
    Stage("clippy", "The compiler's and clippy's warnings, in all code.", "cargo clippy --all-targets --all-features -- -D warnings",
          ("format",), LINT),
    Stage("features", "The engine and the questions build alone; Python and the pages build the rest.",
          "cargo clippy --package kinetostat-engine --package kinetostat-programs --package kinetostat --no-default-features -- -D warnings", ("clippy",), LINT),
    Stage("docs", "Every public item is documented, and links in it lead somewhere.",
          'RUSTDOCFLAGS="-D warnings" cargo doc --no-deps --all-features --document-private-items', ("features",), LINT),
    Stage("links", "Links and pictures in what is read as Markdown lead somewhere.", "python3 tests/docs/check_links.py ./*.md docs studies crates/*/README.md benches/README.md python/README.md web/README.md linuxcnc/README.md .ci/README.md packaging/made_of.md src/README.md"),
    Stage("workflows", "Workflows of GitHub, which are not run here, have no fault that linters find, nor has the Bash in them.", """
        python3 -m venv "$TARGET/ci/linters"
        "$TARGET/ci/linters/bin/pip" install --quiet --requirement tests/workflows/requirements.txt
        PATH="$TARGET/ci/linters/bin:$PATH" actionlint .github/workflows/*.yml
        "$TARGET/ci/linters/bin/check-jsonschema" --builtin-schema vendor.github-workflows .github/workflows/*.yml
    """, ("tools",)),
    Stage("tests", "The README's test command: the claims of the project.", "cargo test --all-features", ("format",)),
    Stage("tools", "Chromium and Python's packages for the stages below.", """
        if ! command -v chromium >/dev/null || ! python3 -c 'import ensurepip' 2>/dev/null; then
            apt-get update -qq
            DEBIAN_FRONTEND=noninteractive apt-get install -qq -y --no-install-recommends chromium python3-venv fonts-dejavu-core
        fi
    """ + PAGE_TOOLS),
    Stage("pages", "The program as README and guide run it, and a map, a path and a placement in a browser.",
          'tests/page/check.sh brief "$OUT" "$PROGRAM" "$TARGET/ci/venv/bin/python"', ("tests", "tools")),
    Stage("python", "The package for Python: built, tested, its types checked.",
          'CARGO_TARGET_DIR="$TARGET" KINETOSTAT="$PROGRAM" python/check.sh', ("tests",)),
    Stage("shipped", "The engine that pages carry answers as the program does.", """
        node web/calls.mjs > "$OUT/calls"
        "$TARGET/debug/examples/explore" < "$OUT/calls" > "$OUT/native"
        node web/check.mjs "$OUT/calls" "$OUT/native" src/page/assets/engine.wasm.br
    """, ("tests",)),
    Stage("controllers", "Generated code: built, linked by C, held against the program.",
          'KINETOSTAT="$PROGRAM" tests/realtime/check.sh 2000', ("tests",)),
    Stage("jobs", "A job array of Slurm, without it.", 'tests/parts/slurm.sh "$PROGRAM"', ("tests",)),
    Stage("full", "What is not here has been run not long ago.", "python3 .ci/stages.py full --ago"),
]

FULL = [
    Stage("program", "What the stages below run.", "cargo build --all-features --bins --examples"),
    Stage("properties", "20 times the cases of `cargo test`, from new seeds: an hour of draws finds what a fixed seed does not.", """
        export INVARIANT_CASES=20 PROPTEST_RNG_SEED=${PROPTEST_RNG_SEED:-$(date +%s)}
        echo "PROPTEST_RNG_SEED=$PROPTEST_RNG_SEED draws the same again"
        modules=$(grep -lE 'proptest!|\\bcases\\(' tests/it/*.rs crates/*/tests/it/*.rs | xargs -n 1 basename -s .rs | sed 's/$/::/')
        cargo test --all-features --test it -- $modules
    """, ("program",)),
    Stage("long", "Tests marked ignored: kills at random moments, long paths, hundreds of machines, intervals of all machines, changed inputs.", """
        export PROPTEST_RNG_SEED=${PROPTEST_RNG_SEED:-$(date +%s)} FUZZ_SEED=${FUZZ_SEED:-$(date +%s)} FUZZ_SECONDS=5
        echo "PROPTEST_RNG_SEED=$PROPTEST_RNG_SEED FUZZ_SEED=$FUZZ_SEED draws the same again"
        # Exudyn, for its beams.
        python3 -m venv "$TARGET/ci/foreign"
        "$TARGET/ci/foreign/bin/pip" install --quiet --requirement tests/foreign_truths/requirements.txt
        export PATH="$TARGET/ci/foreign/bin:$PATH"
        URDF_FOLDERS="$PWD/tests/urdf" cargo test --all-features --test it -- --ignored
        cargo test --package kinetostat-removal -- --ignored
    """, ("program",)),
    Stage("assertions", "With debug assertions and checks of overflow, also of packages, which take a third of the time: compiles everything once more.", """
        all='profile.dev.package."*"'
        # The cases of every run: few new draws reach too little for tests that count what they reached.
        unset PROPTEST_RNG_SEED INVARIANT_CASES
        cargo test --all-features --config "$all.debug-assertions=true" --config "$all.overflow-checks=true"
    """, ("properties",), {"CARGO_PROFILE_DEV_DEBUG_ASSERTIONS": "true", "CARGO_TARGET_DIR": str(TARGET / "assertions")}),
    Stage("question", "A new question is one folder and one line: compiles the program once more.", "tests/question/add.sh",
          ("program",), {"CARGO_TARGET_DIR": str(TARGET / "question")}),
    Stage("package", "What others get is complete, and its examples run: compiles a copy.", """
        rm -f "$TARGET"/package/kinetostat-*.crate
        cargo package --quiet --allow-dirty --no-verify
        for packed in "$TARGET"/package/kinetostat-*.crate; do
            tar -xf "$packed" -C "$OUT"
        done
        # Each of the packed copies, with those below it.
        patch=()
        for below in $(ls crates); do
            patch+=(--config "patch.crates-io.kinetostat-$below.path='$(echo "$OUT/kinetostat-$below"-*)'")
        done
        cargo check --quiet --all-features "${patch[@]}" --manifest-path "$OUT"/kinetostat-[0-9]*/Cargo.toml --target-dir "$TARGET/lint"
        for example in equilibrium map compensate; do
            "$TARGET/debug/examples/$example" > "$OUT/$example.txt"
        done
        "$TARGET/debug/examples/place" studies/03_placement_circle "$OUT/placed" > "$OUT/place.txt"
        grep -q "leaves up to" "$OUT/compensate.txt"
        test -s "$OUT/placed/report.html"
    """, ("program",)),
    Stage("packages", "Archive and wheel as others get them, tried where there is nothing but libc and Python: release builds take minutes.", """
        python3 -m venv "$OUT/packages_venv"
        export PATH="$OUT/packages_venv/bin:$PATH"
        pip install --quiet --requirement packaging/requirements.txt
        archive=$(packaging/make.py archive --out "$OUT/packages")
        again=$(packaging/make.py archive --out "$OUT/packages_again")
        cmp "$archive" "$again"
        wheel=$(packaging/make.py wheel --out "$OUT/packages")
        packaging/try.py "$archive" "$wheel"
    """, ("pages",)),
    Stage("guide", "The guide as a book, without warnings: mdBook is compiled if it is not there.", """
        mdbook=0.5.4
        export PATH="$TARGET/tools/bin:$PATH"
        if [ "$(mdbook --version 2>/dev/null)" != "mdbook v$mdbook" ]; then
            cargo install --quiet --locked --version "$mdbook" --no-default-features --root "$TARGET/tools" --target-dir "$TARGET/mdbook" mdbook
        fi
        mdbook build docs --dest-dir "$OUT/guide" 2>&1 | tee "$OUT/guide.log"
        if grep -qE 'WARN|ERROR' "$OUT/guide.log"; then exit 1; fi
        python3 tests/docs/check_links.py "$OUT/guide"
    """),
    Stage("pages", "All pages in Chromium and Firefox, at all widths, printed, without WebGL: minutes of browsers.", """
        if ! command -v chromium >/dev/null || ! command -v firefox-esr >/dev/null || ! python3 -c 'import ensurepip' 2>/dev/null; then
            apt-get update -qq
            DEBIAN_FRONTEND=noninteractive apt-get install -qq -y --no-install-recommends chromium firefox-esr python3-venv fonts-dejavu-core
        fi
        npm ci --silent --no-audit --no-fund --prefix tests/page/firefox
    """ + PAGE_TOOLS + 'tests/page/check.sh all "$OUT" "$PROGRAM" "$TARGET/ci/venv/bin/python"', ("program",)),
    Stage("engine", "The engine of the pages, made anew, held bit by bit against the program and tried in pages: compiles for the web.", """
        mkdir -p "$OUT/engine"
        web/build.sh "$OUT/engine"
        node web/calls.mjs > "$OUT/calls"
        "$TARGET/debug/examples/explore" < "$OUT/calls" > "$OUT/native"
        node web/check.mjs "$OUT/calls" "$OUT/native" src/page/assets/engine.wasm.br "$OUT/engine/engine.wasm.br"
        "$TARGET/ci/venv/bin/python" tests/page/explore.py "$OUT/explored" "$PROGRAM"
    """, ("pages",)),
    Stage("oracles", "Random programs of each dialect, judged by interpreters of other hands, and random cuts by a geometry of another hand: the program runs twice for each.", """
        for dialect in sinumerik heidenhain fanuc apt; do
            python3 tests/oracles/check.py "$PROGRAM" --dialect $dialect --from 1 --count 40
        done
        for dialect in rapid krl urscript fanuc_ls; do
            ORC_SIMPLE=1 python3 tests/oracles/check_robots.py "$PROGRAM" --dialect $dialect --from 1 --count 30
        done
        python3 tests/oracles/check_robots.py "$PROGRAM" --dialect rapid --from 100 --count 40
        python3 tests/oracles/five_axis.py
        mkdir -p "$OUT/poses"
        python3 tests/oracles/five_axis.py --poses "$OUT/poses"
        diff -r crates/programs/tests/five_axis_poses "$OUT/poses"
        python3 tests/oracles/check_five.py "$PROGRAM" --from 1 --count 60
        for dialect in urscript rapid krl sinumerik; do
            python3 tests/oracles/compositions.py "$PROGRAM" --dialect $dialect --from 1 --count 15
        done
        for dialect in heidenhain sinumerik_frames iso planes fanuc_ls apt rapid_frames krl_frames; do
            python3 tests/oracles/compositions.py "$PROGRAM" --dialect $dialect --from 1 --count 4
        done
        python3 tests/oracles/compositions.py "$PROGRAM" --deep
        # About 60 judged cuts of flat ends, and some of balls and corners.
        python3 -m venv "$OUT/geometry"
        "$OUT/geometry/bin/pip" install --quiet --requirement tests/oracles/requirements.txt
        "$OUT/geometry/bin/python" tests/oracles/engagement.py
        "$OUT/geometry/bin/python" tests/oracles/check_engagement.py "$PROGRAM" --from 1 --count 8
        "$OUT/geometry/bin/python" tests/oracles/check_engagement.py "$PROGRAM" --from 1 --count 2 --shape bull_nose
        "$OUT/geometry/bin/python" tests/oracles/check_engagement.py "$PROGRAM" --from 1 --count 1 --shape ball
    """, ("program",)),
    Stage("bodies", "Distances of bodies against another library, sweeps against samples by kinematics of another hand, recommended places against paths: thousands of poses and hundreds of studies.", """
        pairs="$TARGET/debug/examples/pairs"
        python3 -m venv "$OUT/coal"
        "$OUT/coal/bin/pip" install --quiet --requirement tests/oracles/requirements.txt
        "$pairs" 1 20000 | "$OUT/coal/bin/python" crates/cell/tests/against_coal.py
        "$OUT/coal/bin/python" tests/oracles/bodies.py "$PROGRAM" "$pairs"
        "$OUT/coal/bin/python" tests/oracles/sweeps.py "$PROGRAM"
        for study in 03_placement_circle 04_placement_pocket; do
            python3 tests/oracles/allowance.py "$PROGRAM" studies/$study results/$study
        done
    """, ("program",)),
    Stage("exchange", "Parquet and VTK files, read by other programs: these are large to install.", """
        python3 -m venv "$OUT/readers"
        "$OUT/readers/bin/pip" install --quiet --no-deps --requirement tests/exchange/requirements.txt
        "$PROGRAM" run studies/01_workspace_map --grid 5,4,3 --no-figures --format csv,parquet,vti --out "$OUT/map"
        "$PROGRAM" run studies/05_superposition --grid 3 --no-figures --format csv,parquet,vti --out "$OUT/sums"
        "$PROGRAM" run studies/02_groove_50mm --points 37 --format csv,parquet --out "$OUT/path"
        for folder in map sums path; do
            "$OUT/readers/bin/python" tests/exchange/check_exchange.py "$OUT/$folder"
        done
    """, ("program",)),
    Stage("controllers", "Generated code, 20000 states, calls counted in instructions.", 'KINETOSTAT="$PROGRAM" tests/realtime/check.sh 20000',
          ("program",)),
    Stage("processors", "The same bytes with fused multiply-add and without: an emulator is slow.", """
        if ! command -v qemu-x86_64 >/dev/null; then
            apt-get update -qq
            DEBIAN_FRONTEND=noninteractive apt-get install -qq -y --no-install-recommends qemu-user
        fi
        tests/processors/check.sh "$PROGRAM" "$OUT/processors"
    """, ("program",)),
    Stage("linuxcnc", "The kinematics in LinuxCNC's simulator, which is large to install, and its interpreter on contours.", '''
        KINETOSTAT="$PROGRAM" linuxcnc/test.sh
        python3 tests/oracles/check_centre_path.py "$PROGRAM" --count 300
    ''', ("controllers",)),
]


class Runner:
    """Runs stages, each when those that it comes after have passed; `goes_on`: also when others have failed."""

    def __init__(self, stages, out, known, goes_on):
        self.stages, self.results, self.goes_on = stages, dict(known), goes_on
        self.env = os.environ | {
            "OUT": str(out),
            "TARGET": str(TARGET),
            "PROGRAM": str(TARGET / "debug/kinetostat"),
            # Everything is built once: what would be needed to build it again is not kept.
            "CARGO_INCREMENTAL": "0",
        }
        self.began, self.lock, self.running, self.stopped = time.monotonic(), threading.Lock(), set(), False

    def say(self, text):
        with self.lock:
            seconds = int(time.monotonic() - self.began)
            print(f"{seconds // 60:3d} min {seconds % 60:02d} s  {text}", flush=True)

    def one(self, stage):
        log = STATE / f"{stage.name}.log"
        script = f"set -euo pipefail\n{stage.script}"
        began = time.monotonic()
        with log.open("wb") as output:
            process = subprocess.Popen(
                ["bash", "-c", script], cwd=ROOT, env=self.env | stage.env, stdin=subprocess.DEVNULL, stdout=output, stderr=output,
                start_new_session=True,
            )
            self.running.add(process.pid)
            _, status, usage = os.wait4(process.pid, 0)
            self.running.discard(process.pid)
        process.returncode = os.waitstatus_to_exitcode(status)
        passed = process.returncode == 0
        result = {"passed": passed, "processor_s": usage.ru_utime + usage.ru_stime, "clock_s": time.monotonic() - began}
        if self.stopped:
            return result
        self.say(f"{'passed' if passed else 'FAILED'} {stage.name}: {seconds(result)}")
        if not passed:
            lines = log.read_text(errors="replace").splitlines()
            with self.lock:
                print(f"-- the end of {log}", *lines[-150:], f"-- {stage.name} failed", sep="\n", flush=True)
        return result

    def all(self, keep):
        """Runs what is not known to pass; `keep` gets the results after each stage. Whether all have passed."""
        names = {stage.name for stage in self.stages}
        waiting = [stage for stage in self.stages if not self.results.get(stage.name, {}).get("passed")]
        for stage in self.stages:
            if stage not in waiting:
                print(f"passed before  {stage.name}: {seconds(self.results[stage.name])}")
        done = {stage.name for stage in self.stages if stage not in waiting}
        with concurrent.futures.ThreadPoolExecutor(max(2, os.cpu_count() or 2)) as pool:
            futures = {}
            failed = False
            while waiting or futures:
                ready = [stage for stage in waiting if not (set(stage.after) & names) - done]
                free = max(2, os.cpu_count() or 2) - len(futures)
                for stage in ready[:free] if self.goes_on or not failed else []:
                    waiting.remove(stage)
                    self.say(f"{stage.name} begins")
                    futures[pool.submit(self.one, stage)] = stage
                if not futures:
                    break
                for future in concurrent.futures.wait(futures, return_when=concurrent.futures.FIRST_COMPLETED).done:
                    stage = futures.pop(future)
                    self.results[stage.name] = future.result()
                    if self.results[stage.name]["passed"]:
                        done.add(stage.name)
                    else:
                        failed = True
                    keep(self.results)
        return not failed

    def stop(self):
        self.stopped = True
        for pid in list(self.running):
            with contextlib.suppress(ProcessLookupError):
                os.killpg(pid, signal.SIGTERM)


def seconds(result):
    return f"{result['processor_s']:.0f} s of processor time, {result['clock_s']:.0f} s by the clock"


def git(*arguments, env=None):
    return subprocess.run(["git", *arguments], cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True, env=env).stdout.strip()


def tree_of(commit=None):
    """The hash of the tree of `commit`, or of the files there are, but for what is apart."""
    with tempfile.TemporaryDirectory() as folder:
        env = os.environ | {"GIT_INDEX_FILE": f"{folder}/index"}
        git("read-tree", commit or "HEAD", env=env)
        if commit is None:
            git("add", "--all", env=env)
        git("rm", "--cached", "--force", "--quiet", "--ignore-unmatch", "-r", *APART, env=env)
        return git("write-tree", env=env)


def ago():
    """Says how many commits ago .ci/full has passed, and whether that is not too long ago."""
    lines = [line.split("\t") for line in (ROOT / LOG).read_text().splitlines()] if (ROOT / LOG).exists() else []
    passed = [line[1] for line in lines if len(line) > 2 and line[2] == "passed"]
    if subprocess.run(["git", "rev-parse", "--verify", "--quiet", "HEAD"], cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode != 0:
        return print("there is no history here: how long ago .ci/full has passed is not known")
    if git("rev-parse", "--is-shallow-repository") == "true":
        return print("the history here is not whole: how long ago .ci/full has passed is not known")
    commits = git("rev-list", f"--max-count={MAX_COMMITS + 1}", "HEAD").split()
    count = next((count for count, commit in enumerate(commits) if tree_of(commit) in passed), None) if passed else None
    if count is not None:
        print(f".ci/full passed on the tree of {count} commits ago")
    else:
        # Of a history that was rewritten, and before the first pass, what is known is when the pass was written, or that there is such a check.
        written = git("log", "-1", "--format=%H", f"-S{passed[-1]}", "--", LOG) if passed else ""
        since = written or git("log", "-1", "--diff-filter=A", "--format=%H", "--", ".ci/full")
        count = int(git("rev-list", "--count", "HEAD", f"^{since}"))
        print(f"none of the last {len(commits)} commits has a tree on which .ci/full passed; {'its pass was written' if written else 'there is .ci/full since'} {count} commits ago")
    if count > MAX_COMMITS:
        sys.exit(f"more than {MAX_COMMITS} commits ago: run .ci/full and commit {LOG}")


def record(tree, results, stages):
    """Adds a line to the log: when, which tree, what came of it, and the stages with their seconds of processor time."""
    def one(stage):
        result = results.get(stage.name)
        if result is None:
            return f"{stage.name} not run"
        return f"{stage.name} {'' if result['passed'] else 'FAILED '}{result['processor_s']:.0f} s"

    passed = all(results.get(stage.name, {}).get("passed") for stage in stages)
    line = "\t".join([datetime.date.today().isoformat(), tree, "passed" if passed else "failed", ", ".join(map(one, stages))])
    file = ROOT / LOG
    lines = [*(file.read_text().splitlines() if file.exists() else []), line]
    # The last pass stays, however often it has failed since.
    last_pass = [other for other in lines[:-MAX_LINES] if other.split("\t")[2] == "passed"][-1:]
    file.write_text("\n".join([*last_pass, *lines[-MAX_LINES:]]) + "\n")


def table(stages, results):
    known = [stage for stage in stages if stage.name in results]
    rows = [(stage.name, results[stage.name]["processor_s"], results[stage.name]["clock_s"], stage.reason) for stage in known]
    lines = ["| stage | processor s | clock s | what for |", "|---|---:|---:|---|"]
    lines += [f"| {name} | {processor:.0f} | {clock:.0f} | {reason} |" for name, processor, clock, reason in rows]
    lines.append(f"| all | {sum(row[1] for row in rows):.0f} | | |")
    return "\n".join(lines)


def main():
    which = sys.argv[1]
    parser = argparse.ArgumentParser(prog=f".ci/{which}", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--list", action="store_true", help="say what each stage is for")
    parser.add_argument("--table", action="store_true", help="print the seconds of the last run as Markdown")
    parser.add_argument("stages", nargs="*", metavar="STAGE", help="only these, without those that they come after")
    if which == "full":
        parser.add_argument("--again", action="store_true", help="also what has passed on this tree")
        parser.add_argument("--ago", action="store_true", help="say how many commits ago it has passed")
    options = parser.parse_args(sys.argv[2:])
    stages = {"run": RUN, "full": FULL}[which]
    unknown = set(options.stages) - {stage.name for stage in stages}
    if unknown:
        parser.error(f"no stage {', '.join(sorted(unknown))}: expected {', '.join(stage.name for stage in stages)}")
    if which == "full" and options.ago:
        return ago()
    STATE.mkdir(parents=True, exist_ok=True)
    file = STATE / f"{which}.json"
    state = json.loads(file.read_text()) if file.exists() else {}
    if options.list:
        return print(*(f"{stage.name:12} {stage.reason}" for stage in stages), sep="\n")
    if options.table:
        return print(table(stages, state.get("results", {})))
    if which == "full" and not (ROOT / ".git").exists():
        parser.error("needs the git repository: it goes on, and is written down, by what git knows of the files")
    tree = tree_of() if which == "full" else ""
    goes_on = which == "full" and not options.again and state.get("tree") == tree
    known = {name: result for name, result in state.get("results", {}).items() if result["passed"] and name != "program"} if goes_on else {}
    chosen = [stage for stage in stages if not options.stages or stage.name in options.stages]

    def keep(results):
        if which == "full" and tree_of() != tree:
            return
        written = file.with_suffix(".new")
        written.write_text(json.dumps({"tree": tree, "results": results}))
        written.replace(file)

    out = Path(tempfile.mkdtemp())
    runner = Runner(chosen, out, known, which == "full")

    def interrupted(number, _):
        runner.stop()
        sys.exit(128 + number)

    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, interrupted)
    try:
        passed = runner.all(keep)
    finally:
        runner.stop()
        shutil.rmtree(out, ignore_errors=True)
    results = runner.results
    print(table(stages, results))
    if which == "full" and tree_of() != tree:
        sys.exit("files have changed meanwhile: nothing of this is kept")
    if which == "full" and (not passed or all(stage.name in results for stage in stages)):
        record(tree, results, stages)
        print(f"written to {LOG}: commit it")
    sys.exit(0 if passed else 1)


if __name__ == "__main__":
    main()
