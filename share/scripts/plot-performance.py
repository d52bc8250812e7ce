#!/usr/bin/env python3
"""Draws share/doc/images/performance/*.svg and rewrites the tables of share/doc/performance.md from the
JSON that bench_backend writes; see there for the command."""

import argparse
import collections
import json
import pathlib
import subprocess
import sys

DOC = pathlib.Path(__file__).resolve().parent.parent / "doc"
BEGIN, END = "<!-- measured: begin -->", "<!-- measured: end -->"
OUR_METHODS = ["batch", "batch_step", "incremental", "windowed"]
KEYFRAME_METHODS = OUR_METHODS + ["ceres", "mrpt"]
PHASES = [("order_ms", "ordering"), ("symb_ms", "symbolic"), ("lin_ms", "linearise"),
          ("num_ms", "numeric"), ("solve_ms", "solve")]
SVG_SIZE = "720,460"


def read(files):
    """Benchmarks by name without suffixes: {"Map/keyframe/batch": {500: entry}}, sizes 0 without."""
    found = collections.defaultdict(dict)
    for file in files:
        for entry in json.loads(pathlib.Path(file).read_text())["benchmarks"]:
            if entry.get("error_occurred"):
                print(f"left out: {entry['name']}: {entry['error_message']}", file=sys.stderr)
                continue
            parts = [p for p in entry["name"].split("/")
                     if p != "manual_time" and not p.startswith("iterations:")]
            size = int(parts.pop()) if parts[-1].isdigit() else 0
            found["/".join(parts)][size] = entry
    return found


def number(x):
    return f"{x:.0f}" if x >= 100 else f"{x:.3g}"


def row(cells):
    return "| " + " | ".join(cells) + " |\n"


def table(head, rows):
    return row(head) + "|" + "---|" * len(head) + "\n" + "".join(row(r) for r in rows) + "\n"


def times(found, name, sizes):
    return [number(found[name][s]["real_time"]) if s in found[name] else "–" for s in sizes]


def map_tables(found):
    sizes = sorted({s for name in found if name.startswith("Map/") for s in found[name]})
    head = [f"{s} keyframes" for s in sizes]
    text = "Mean time of a keyframe at these sizes, and of the marginal covariances [ms]:\n\n"
    rows = [[m] + times(found, f"Map/keyframe/{m}", sizes) for m in KEYFRAME_METHODS
            if f"Map/keyframe/{m}" in found]
    for m in KEYFRAME_METHODS:
        if f"Map/life/{m}" in found:
            rows.append([f"{m}, mean since the first keyframe"] + times(found, f"Map/life/{m}", sizes))
    rows.append(["batch, one step with everything anew"] + times(found, "Map/one_step", sizes))
    rows.append(["batch, from dead reckoning to the minimum"] + times(found, "Map/to_convergence", sizes))
    rows.append(["covariance of one node"] + times(found, "Map/marginals_of_one", sizes))
    rows.append(["covariances of all nodes"] + times(found, "Map/marginals_of_all", sizes))
    text += table([""] + head, rows)

    text += "Times of Ceres' keyframe over ours, and cost over the minimum's at the end:\n\n"
    rows = []
    for m in OUR_METHODS:
        entries = found.get(f"Map/keyframe/{m}", {})
        ceres = found.get("Map/keyframe/ceres", {})
        rows.append([f"Ceres / {m}"] + [number(ceres[s]["real_time"] / entries[s]["real_time"]) + "×"
                                        if s in entries and s in ceres else "–" for s in sizes])
    for m in OUR_METHODS:
        entries = found.get(f"Map/keyframe/{m}", {})
        rows.append([f"cost of {m}"] + [f"+ {max(entries[s]['excess'], 0.0):.0e}" if s in entries else "–"
                                        for s in sizes])
    text += table([""] + head, rows)

    text += "Phases of a keyframe [ms]:\n\n"
    rows = []
    for m in OUR_METHODS:
        for s in sizes:
            e = found.get(f"Map/keyframe/{m}", {}).get(s)
            if e:
                rows.append([m, str(s), str(int(e["nodes"]))] + [number(e[key]) for key, _ in PHASES]
                            + [number(e["real_time"]), number(e["longest_ms"])])
    return text + table(["", "keyframes", "nodes"] + [name for _, name in PHASES] + ["all", "longest"], rows)


def pose_graph_table(found):
    names = sorted({n.split("/")[1] for n in found if n.startswith("PoseGraph/")})
    rows = []
    for name in names:
        get = lambda method: found.get(f"PoseGraph/{name}/{method}", {}).get(0)
        ours, ceres, mrpt = get("batch"), get("ceres"), get("mrpt")
        if not ours or not ceres:
            continue
        rows.append([name, number(ours["real_time"]), number(ceres["real_time"]),
                     number(mrpt["real_time"]) if mrpt else "–",
                     f"{ours['real_time'] / ceres['real_time']:.2f}",
                     f"{ours['cost']:.6g}", f"{ceres['cost']:.6g}"])
    text = "Public pose graphs [ms]; costs F = ½ Σ eᵀΩe:\n\n"
    text += table(["", "batch", "Ceres", "MRPT", "batch / Ceres", "F, batch", "F, Ceres"], rows)
    for name in names:
        guess = found.get(f"PoseGraph/{name}/file_guess", {}).get(0)
        other = {"torus3D": ("batch", "the time from the relaxation's poses"),
                 "sphere2500": ("ceres", "Ceres's time")}.get(name)
        if guess and other and found.get(f"PoseGraph/{name}/{other[0]}"):
            ratio = guess["real_time"] / found[f"PoseGraph/{name}/{other[0]}"][0]["real_time"]
            text += (f"{name} from the file's own guess as `dynemo-optimize` solves it, chordal relaxation and all: "
                     f"{number(guess['real_time'])} ms, {ratio:.2f}× {other[1]}.\n\n")
    return text


def gnuplot(name, commands):
    file = DOC / "images" / "performance" / f"{name}.svg"
    script = (f"set terminal svg noenhanced size {SVG_SIZE} font 'sans,13' background 'white'\nset output '{file}'\n"
              "set grid\nset key left top\n" + commands)
    subprocess.run(["gnuplot"], input=script, text=True, check=True)


def plot_keyframes(found):
    curves, blocks = [], ""
    for m in KEYFRAME_METHODS:
        entries = found.get(f"Map/keyframe/{m}", {})
        if not entries:
            continue
        points = "\n".join(f"{4 * s} {e['real_time']}" for s, e in sorted(entries.items()))
        blocks += f"${m} << EOD\n{points}\nEOD\n"
        curves.append(f"${m} using 1:2 with linespoints lw 2 title '{m}'")
    gnuplot("keyframe", blocks + "set logscale xy\nset xlabel 'nodes'\nset ylabel 'time of a keyframe [ms]'\nplot "
            + ", ".join(curves) + "\n")


def plot_phases(found):
    entries = sorted(found.get("Map/keyframe/incremental", {}).items())
    data = "\n".join(f"{s} " + " ".join(str(e[key]) for key, _ in PHASES) for s, e in entries)
    curves = ", ".join(f"$data using {i + 2}:xtic(1) title '{name}'" for i, (_, name) in enumerate(PHASES))
    gnuplot("phases", f"$data << EOD\n{data}\nEOD\nset style data histograms\nset style histogram rowstacked\n"
            "set style fill solid 0.8\nset boxwidth 0.6\nset xlabel 'keyframes'\n"
            f"set ylabel 'time of a keyframe, incremental [ms]'\nplot {curves}\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("json", nargs="+", help="output of bench_backend --benchmark_out")
    found = read(parser.parse_args().json)
    page = DOC / "performance.md"
    text = page.read_text()
    before, after = text.split(BEGIN)[0], text.split(END)[1]
    page.write_text(before + BEGIN + "\n" + map_tables(found) + pose_graph_table(found) + END + after)
    (DOC / "images" / "performance").mkdir(parents=True, exist_ok=True)
    plot_keyframes(found)
    plot_phases(found)


if __name__ == "__main__":
    main()
