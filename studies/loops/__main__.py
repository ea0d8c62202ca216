"""Six closed loops as a benchmark. From the folder of the repository:

python -m studies.loops --seeds 5
python -m studies.loops --quick --loops rope_tip
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from functools import partial
from pathlib import Path
from typing import Any, get_args

from bendtwin import Twin
from studies.lab import Lab, binary, open_lab
from studies.loops import report
from studies.loops.bin import Bin
from studies.loops.box import Box
from studies.loops.cable import Cable
from studies.loops.episode import Episode, Variant
from studies.loops.harness import run_episode
from studies.loops.loop import Loop
from studies.loops.peg import Peg
from studies.loops.push import Push
from studies.loops.rope_tip import RopeTip

LOOPS: dict[str, type[Loop]] = {loop.name: loop for loop in (RopeTip, Box, Peg, Cable, Bin, Push)}
#: Drafts: coarse, so that many plans are simulated in the time of a step. The twin that plans knows
#: the material as a whole, the one that stands for the real object has it spring by spring.
BODY = {
    "graph": {"max_nodes": 60, "max_neighbours": 8},
    "search": {"generations": 6, "starts": 1},
}
CABLE = {"search": {"generations": 10, "starts": 1, "population": 16}}
PASSES = {"planning": 0, "real": 3}
QUICK_STEPS = 5


def twins(lab: Lab, loop: type[Loop], tiny: bool) -> tuple[Twin, Twin]:
    """The twin that plans, and the one that stands for the real object."""
    settings: dict[str, Any] = CABLE if loop.scene == "cable" else BODY
    planning, real = (
        lab.twin(
            f"loop-{loop.scene}-{name}{'-tiny' * tiny}",
            {**settings, "refine": {"passes": passes}},
            partial(lab.made, loop.scene, tiny=tiny, mass_kg=loop.mass_kg),
        )
        for name, passes in PASSES.items()
    )
    return planning, real


def main() -> int:
    """Runs the loops and prints their tables; 1 if an episode could not be run to its end."""
    options = _options()
    chosen = [LOOPS[name] for name in options.loops.split(",")]
    variants: list[Variant] = options.variants.split(",")
    seeds = range(options.first_seed, options.first_seed + (1 if options.quick else options.seeds))
    steps = QUICK_STEPS if options.quick else None
    episodes: list[Episode] = []
    with open_lab(binary(options.bin), kept=options.twins, cores=options.cores) as lab:
        for loop in chosen:
            pair = twins(lab, loop, tiny=options.quick)
            for variant in variants:
                for seed in seeds:
                    began = time.monotonic()
                    episodes.append(run_episode(lab.client, loop, pair, variant, seed, steps))
                    _tell(episodes[-1], time.monotonic() - began)
    document = {"command": sys.argv[1:], **report.document(episodes)}
    if options.out:
        options.out.write_text(json.dumps(document, indent=1))
    print(json.dumps(document, indent=1) if options.json else report.markdown(episodes))
    return 0


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m studies.loops",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    known = ",".join(get_args(Variant))
    parser.add_argument("--bin", help="the program [default: BENDTWIN_BIN, or that on the path]")
    parser.add_argument("--loops", default=",".join(LOOPS), help="[default: %(default)s]")
    parser.add_argument("--seeds", type=int, default=5, help="episodes of each [default: 5]")
    parser.add_argument("--first-seed", type=int, default=0, help="[default: 0]")
    parser.add_argument(
        "--variants", default="corrected,open_loop", help=f"of {known} [default: %(default)s]"
    )
    parser.add_argument("--quick", action="store_true", help="one seed, few steps, tiny recordings")
    parser.add_argument("--cores", type=int, default=2, help="of the server [default: 2]")
    parser.add_argument("--twins", type=Path, help="folder in which twins are kept between runs")
    parser.add_argument("--json", action="store_true", help="print JSON instead of tables")
    parser.add_argument("--out", type=Path, help="file for the JSON")
    options = parser.parse_args()
    unknown = set(options.loops.split(",")) - LOOPS.keys()
    unknown |= set(options.variants.split(",")) - set(get_args(Variant))
    if unknown:
        parser.error(f"unknown: {', '.join(sorted(unknown))}")
    return options


def _tell(episode: Episode, took_s: float) -> None:
    """Says on the error stream what an episode came to."""
    verdict = "ok" if episode.success else "failed"
    print(
        f"{episode.loop} {episode.variant} seed {episode.seed}: {verdict}, "
        f"{episode.error_mm:.1f} mm, strain {episode.largest_strain:.2f}, "
        f"{episode.largest_force_n:.1f} N, refused {episode.refused_corrections} of "
        f"{episode.corrections} {episode.also or ''} {episode.ended_by} ({took_s:.0f} s)",
        file=sys.stderr,
    )


if __name__ == "__main__":
    sys.exit(main())
