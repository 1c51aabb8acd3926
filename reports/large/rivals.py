"""Programs that thin a survey of many files, side by side: time, memory and error at about equal counts.

    python tests/benchmarks/make_survey.py SURVEY
    python reports/large/rivals.py SURVEY [--reduction 0.9] [--memory 4GiB] --folder FOLDER

Writes rivals.csv beside this file, one row for each program, after each one. Seconds and memory are those of the
program with all that it starts. Programs that cannot read LAZ get the survey as one binary PLY, which is made before;
cell sizes and distances that give the count are searched before, on the first file or by counting cells.
Errors are measured at 200,000 original points drawn at random, the same for all. A run that was stopped is continued.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import threading
import time
from contextlib import suppress
from pathlib import Path

import laspy
import numpy as np
import pandas as pd
import psutil

import lpcompare as lp

HERE = Path(__file__).parent
CHUNK = 1_000_000
QUIET = [
    "-SILENT",
    "-AUTO_SAVE",
    "OFF",
    "-NO_TIMESTAMP",
    "-C_EXPORT_FMT",
    "PLY",
    "-PLY_EXPORT_FMT",
    "BINARY_LE",
    "-O",
]
JUDGED = 200_000
COLUMNS = ("plane_error", "plane_error_pct", "mean_distance_pct")


def survey_points(folder):
    """All coordinates, shape (n, 3), about the middle of the survey, and the middle."""
    points = np.concatenate([laspy.read(path).xyz for path in sorted(folder.glob("*.laz"))])
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    return points - middle, middle


def write_ply(path, points):
    """One binary PLY in single precision, the format that the others read."""
    head = "".join(f"property float {axis}\n" for axis in "xyz")
    text = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n{head}end_header\n"
    path.write_bytes(text.encode() + points.astype("<f4").tobytes())


def cells(points, size):
    """Occupied cells of a grid."""
    places = np.floor((points - points.min(axis=0)) / size).astype(np.int64)
    wide = places.max(axis=0) + 1
    return len(np.unique((places[:, 0] * wide[1] + places[:, 1]) * wide[2] + places[:, 2]))


def searched(count, wanted, size):
    """The size at which ``count`` is within half a percent of what is wanted."""
    low, high = size / 50, size * 50
    for _ in range(40):
        found = count(size)
        if abs(found - wanted) <= 0.005 * wanted:
            break
        low, high = (size, high) if found > wanted else (low, size)
        size = (low * high) ** 0.5
    return size


def cloudcompare(source, target, *words):
    """The command of CloudCompare that thins one file."""
    return ["CloudCompare", *QUIET, str(source), "-SS", *words, "-SAVE_CLOUDS", "FILE", str(target)]


def measured(words):
    """Run a program: seconds on the wall and of processors, and the most memory of all its processes in MiB."""
    peak, over = [0.0], threading.Event()

    def watch(process):
        while not over.wait(0.1):
            with suppress(psutil.Error):
                some = [process, *process.children(recursive=True)]
                peak[0] = max(peak[0], sum(memory(one) for one in some))

    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    environment = os.environ | {"QT_QPA_PLATFORM": "offscreen"}
    with subprocess.Popen(words, env=environment, stdout=subprocess.DEVNULL) as running:
        watcher = threading.Thread(target=watch, args=(psutil.Process(running.pid),))
        watcher.start()
        running.wait()
        over.set()
        watcher.join()
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    if running.returncode:
        raise SystemExit(f"{words[0]} ended with {running.returncode}")
    return {"seconds": time.perf_counter() - begin, "cpu_s": cpu, "peak_mib": peak[0]}


def memory(process):
    """Resident memory in MiB without files that are mapped; 0 of a process that has ended."""
    try:
        info = process.memory_info()
    except psutil.Error:
        return 0.0
    return (info.rss - info.shared) / 2**20


def laspy_random(folder, target, reduction):
    """Stream the files and keep a random choice of rows, as many as lpcompare keeps."""
    paths = sorted(Path(folder).glob("*.laz"))
    sizes = [laspy.open(path).header.point_count for path in paths]
    n_keep = sum(sizes) - round(reduction * sum(sizes))
    kept = np.zeros(sum(sizes), dtype=bool)
    kept[np.random.default_rng(0).permutation(len(kept))[:n_keep]] = True
    header, begin = laspy.open(paths[0]).header, 0
    with laspy.open(target, mode="w", header=header) as writer:
        for path in paths:
            with laspy.open(path) as reader:
                for chunk in reader.chunk_iterator(CHUNK):
                    writer.write_points(chunk[kept[begin : begin + len(chunk)]])
                    begin += len(chunk)


def open3d_voxel(source, target, size):
    """Open3D's voxel grid."""
    import open3d

    cloud = open3d.io.read_point_cloud(source)
    open3d.io.write_point_cloud(target, cloud.voxel_down_sample(size))


def sizes(survey, folder, n_keep):
    """Write the survey as PLY; cell size, distance and level at which the others keep about as many points."""
    known = folder / "sizes.json"
    if known.exists():
        return json.loads(known.read_text())
    points, _ = survey_points(survey)
    n_first = laspy.open(min(survey.glob("*.laz"))).header.point_count
    first, n_keep_first = points[:n_first], round(n_keep * n_first / len(points))
    write_ply(folder / "survey.ply", points)
    write_ply(folder / "first.ply", first)
    spacing = float(np.sqrt(np.prod(np.ptp(points[:, :2], axis=0)) / n_keep))
    side = float(np.ptp(points, axis=0).max())

    def near(distance):
        words = cloudcompare(folder / "first.ply", folder / "thin.ply", "SPATIAL", f"{distance:.6g}")
        measured(words)
        return len(lp.read(folder / "thin.ply"))

    voxel = searched(lambda size: cells(points, size), n_keep, spacing)
    level = min(range(6, 22), key=lambda k: abs(cells(first, side / 2**k) - n_keep_first))
    found = voxel, searched(near, n_keep_first, spacing), level
    known.write_text(json.dumps(found))
    return found


def commands(survey, folder, reduction, memory_limit):
    """The command of each program, and the file that it writes."""
    n_points = count_points(survey)
    n_keep = n_points - round(reduction * n_points)
    voxel, distance, level = sizes(survey, folder, n_keep)
    ply, thin, own = (folder / name for name in ("survey.ply", "thin.ply", "thin.laz"))
    files, script = sorted(map(str, survey.glob("*.laz"))), [sys.executable, __file__]

    def ours(method):
        how = ["--method", method, "--reduction", str(reduction), "--memory", memory_limit, "--force"]
        return [sys.executable, "-m", "lpcompare.cli", "simplify", *files, str(own), *how], own

    def theirs(*words):
        return cloudcompare(ply, thin, *words), thin

    return {
        "lpcompare random_sample": ours("random_sample"),
        "lpcompare voxel_nearest": ours("voxel_nearest"),
        "lpcompare lp_density": ours("lp_density"),
        "laspy streamed random choice": ([*script, "laspy", str(survey), str(own), str(reduction)], own),
        "Open3D voxel grid": ([*script, "open3d", str(ply), str(thin), str(voxel)], thin),
        "CloudCompare SPATIAL": theirs("SPATIAL", f"{distance:.6g}"),
        "CloudCompare OCTREE": theirs("OCTREE", str(level)),
        "CloudCompare RANDOM": theirs("RANDOM", str(n_keep)),
        "lpcompare lp_uniform": ours("lp_uniform"),
    }


def count_points(survey):
    """Points of all files."""
    return sum(laspy.open(path).header.point_count for path in survey.glob("*.laz"))


def main():
    """Measure every program, and write the table after each."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("survey", type=Path)
    parser.add_argument("--reduction", type=float, default=0.9)
    parser.add_argument("--memory", default="4GiB")
    parser.add_argument("--folder", type=Path, required=True, help="where files of passage are written")
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    points, middle = survey_points(given.survey)
    judged = points[np.random.default_rng(0).choice(len(points), min(JUDGED, len(points)), replace=False)]
    table = HERE / "rivals.csv"
    rows = pd.read_csv(table).to_dict("records") if table.exists() else []
    for name, (words, target) in commands(given.survey, given.folder, given.reduction, given.memory).items():
        if name in [row["program"] for row in rows]:
            continue
        target.unlink(missing_ok=True)
        row = {"program": name, "points": len(points)} | measured(words)
        thin = lp.read(target).points
        row |= {"kept": len(thin), "megabytes_written": target.stat().st_size / 1e6}
        thin = thin - (0 if target.suffix == ".ply" else middle)
        figures = lp.evaluate(judged, thin, metrics=("plane_error", "mean_distance"))
        row |= {column: figures[column] for column in COLUMNS}
        rows.append(row)
        pd.DataFrame(rows).to_csv(table, index=False, float_format="%.5g")
        print(row, flush=True)


if __name__ == "__main__":
    if sys.argv[1:2] == ["laspy"]:
        laspy_random(sys.argv[2], sys.argv[3], float(sys.argv[4]))
    elif sys.argv[1:2] == ["open3d"]:
        open3d_voxel(sys.argv[2], sys.argv[3], float(sys.argv[4]))
    else:
        main()
