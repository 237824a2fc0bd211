#!/usr/bin/env python3
"""Compares two files of benches/record: python3 benches/record/compare.py OLD NEW [--fail-below SHARE]

Rows are matched by scene, kind of rays and, for `octray bench`, method. Builds are compared if both files have them.
For Embree files the ratio octray/Embree is compared, else the speed.
"""

import argparse
import json
import math
import sys


def load(path):
    try:
        with open(path, encoding="utf-8") as file:
            data = json.load(file)
    except (OSError, ValueError) as error:
        sys.exit(f"{path}: {error}")
    if data.get("schema") != 1:
        sys.exit(f"{path}: schema {data.get('schema')!r}, expected 1")
    return data


def rows(data):
    """Maps (kind, scene, method) to (speed in Mrays/s, compared value, agrees)."""
    found = {}
    for row in data["results"]:
        key = (row["kind"], row["scene"], row.get("method", ""))
        speed = row["ours"] if "ours" in row else row["mrays_per_s"]
        found[key] = (speed, row.get("ratio", speed), row["agree"])
    return found


def builds(data):
    """Maps ("build", scene, threads) to (seconds, Embree's time over ours: higher is better)."""
    found = {}
    for row in data.get("builds", []):
        for threads in ("1", "2"):
            seconds = row[f"ours_{threads}"]
            found["build", row["scene"], threads] = (seconds, row[f"embree_medium_{threads}"] / seconds)
    return found


def main():
    parser = argparse.ArgumentParser(description="Compares two results of benches/record.")
    parser.add_argument("old")
    parser.add_argument("new")
    parser.add_argument("--fail-below", type=float, default=0.0, metavar="SHARE",
                        help="exit with 5 if a row is below SHARE times its old value, or missing")
    arguments = parser.parse_args()
    old, new = load(arguments.old), load(arguments.new)
    # Older files lack some of these.
    for field in ("machine", "isa", "threads", "avx2", "size", "width", "height", "repeat", "build"):
        if field in old and field in new and old[field] != new[field]:
            print(f"warning: different {field}: {old.get(field)} and {new.get(field)}")

    old_rows, new_rows = rows(old), rows(new)
    has_ratio = any("ratio" in row for row in new["results"])
    what = "octray/Embree" if has_ratio else "Mrays/s"
    print(f"{'rays':8}{'scene':20}{'method':8}{'old ' + what:>20}{'new':>8}{'change':>9}{'Mrays/s now':>13}")
    changes, worst = {}, math.inf
    for key, (speed, value, agrees) in new_rows.items():
        if key not in old_rows:
            print(f"{key[0]:8}{key[1]:20}{key[2]:8}{'new':>20}{value:8.2f}{'':9}{speed:13.2f}")
            continue
        before = old_rows[key][1]
        change = value / before
        worst = min(worst, change)
        changes.setdefault((key[0], key[2]), []).append(change)
        note = "" if agrees else "  does not agree"
        print(f"{key[0]:8}{key[1]:20}{key[2]:8}{before:20.2f}{value:8.2f}{change - 1:+9.1%}{speed:13.2f}{note}")
    missing = sorted(old_rows.keys() - new_rows.keys())
    for key in missing:
        print(f"{key[0]:8}{key[1]:20}{key[2]:8} is only in the old file")

    old_builds, new_builds = builds(old), builds(new)
    for key, (seconds, value) in new_builds.items():
        if key in old_builds:
            before = old_builds[key][1]
            changes.setdefault(("build", f"{key[2]} thr."), []).append(value / before)
            worst = min(worst, value / before)
            print(f"{'build':8}{key[1]:20}{key[2] + ' thr.':8}{before:20.2f}{value:8.2f}"
                  f"{value / before - 1:+9.1%}{seconds * 1e3:10.1f} ms")

    print("\ngeometric mean of the changes")
    for (kind, method), factors in changes.items():
        mean = math.exp(sum(map(math.log, factors)) / len(factors))
        print(f"{kind:8}{method:8}{mean - 1:+8.1%} over {len(factors)}, worst {min(factors) - 1:+.1%}")
    if worst < arguments.fail_below:
        print(f"a row fell to {worst:.2f} of its old value")
        sys.exit(5)
    if arguments.fail_below > 0.0 and (missing or not changes):
        print(f"{len(missing)} rows are missing, {sum(map(len, changes.values()))} were compared")
        sys.exit(5)


if __name__ == "__main__":
    main()
