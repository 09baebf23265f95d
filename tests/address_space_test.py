"""Under any limit on its address space (ulimit -v) a picture is made or refused in a line; nothing hangs or dies by a signal."""
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

DAPPLE = Path(sys.argv[1]).resolve()
SCENE = Path(__file__).resolve().parent / "fixtures/hut.obj"
MIB = 1 << 20


def render(mib, folder):
    limit = lambda: resource.setrlimit(resource.RLIMIT_AS, (mib * MIB, mib * MIB))
    command = [DAPPLE, "render", SCENE, "uniform", "-r", "64x48", "-o", f"{folder}/p.png"]
    try:
        return subprocess.run(command, capture_output=True, text=True, preexec_fn=limit, timeout=120)
    except subprocess.TimeoutExpired:
        return None


def main():
    bad, made = [], 0
    with tempfile.TemporaryDirectory() as folder:
        for mib in [*range(350, 1001, 50), 8000]:
            done = render(mib, folder)
            said = [] if done is None else [line for line in done.stderr.splitlines() if line.startswith("dapple: ")]
            ok = done is not None and (done.returncode == 0 or (done.returncode in (2, 5) and said))
            made += bool(ok) and done.returncode == 0
            if not ok:
                bad.append(f"{mib} MiB: " + ("it hangs" if done is None else f"exit code {done.returncode}, {done.stderr!r}"))
    for line in bad:
        print("    " + line)
    print(f"{'FAILED' if bad or not made else 'ok'}: a limit on addresses ends in a picture ({made} times) or a line")
    return bool(bad) or not made


sys.exit(main())
