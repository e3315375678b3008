"""One worn wheel and one worn rail in every layout of a file of points, times unit, side, direction, order and origin:
how many load right, are refused, or are wrong, which none may be.

    python campaigns/layouts.py [--every 10]

The wheel is S1002, the rail 60E1, both a little worn. A file is right when its points lie on the profile that was
written. Refused are files whose format contradicts their shape, rails of MiniProf that count to the field side and of
SIMPACK that count to the gauge side, and files without a unit that are not in mm.
"""

import argparse
import sys
from collections import Counter
from pathlib import Path
from tempfile import TemporaryDirectory

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from support.profile_texts import cases, outcome

from wrsim.contact.profiles.models import load_profile


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--every", type=int, default=1, help="only every n-th file")
    every, counts, wrong = parser.parse_args().every, Counter[str](), list[str]()
    reasons = dict[str, tuple[int, str]]()
    with TemporaryDirectory() as folder:
        for name in ("wheels/S1002_worn.toml", "rails/60E1_worn.toml"):
            profile = load_profile(name)
            for case in cases(profile, every):
                verdict = outcome(case, profile, Path(folder))
                counts[verdict if verdict in ("right", "wrong") else "refused"] += 1
                if verdict == "wrong":
                    wrong.append(case.label)
                elif verdict != "right":
                    key = f"{case.label.split(',')[0]}: {verdict.partition(': ')[2][:60]}"
                    reasons[key] = (reasons.get(key, (0, ""))[0] + 1, verdict.partition(": ")[2])
    for key, (count, reason) in reasons.items():
        print(f"{count:4d} refused, {key.split(':')[0]}: {reason}")
    print(*(f"wrong: {label}" for label in wrong), sep="\n", end="\n" if wrong else "")
    print(
        f"{sum(counts.values())} files: " + ", ".join(f"{counts[key]} {key}" for key in ("right", "refused", "wrong"))
    )
    return int(bool(wrong))


if __name__ == "__main__":
    sys.exit(main())
