"""What tiles cost: a resampled mesh thinned in tiles and as a whole, and the points kept along seams.

    python reports/large/seams.py MESH [--points 1000000] [--tiles 32 128] [--reduction 0.9]

Writes seams-POINTS.csv beside this file, one row for each number of tiles, and docs/images/seam.png, the kept points
around one seam. Ratios are those over the whole cloud in memory; strip_1 to strip_4 are the kept points at up to one,
two, three and four disk radii from a seam.
"""

import argparse
import tempfile
from pathlib import Path
from time import perf_counter

import matplotlib as mpl
import numpy as np
import pandas as pd

import lpcompare as lp
from lpcompare.geometry.neighbors import Neighbors
from lpcompare.tiles.tiles import tile_of

HERE = Path(__file__).parent
METRICS = ("plane_error", "surface_distance", "hausdorff", "normal_deviation")
COLUMNS = ("plane_error_pct", "surface_distance_pct", "hausdorff_pct", "normal_deviation_deg")


def resampled(path, n_points):
    """Points drawn evenly from the triangles of a mesh, in random order."""
    mesh, rng = lp.read(path), np.random.default_rng(1)
    corners = mesh.points[mesh.faces]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    some = corners[rng.choice(len(areas), n_points, p=areas / areas.sum())]
    u, v = rng.random((2, n_points, 1))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    return some[:, 0] + u * (some[:, 1] - some[:, 0]) + v * (some[:, 2] - some[:, 0])


def seam_distances(points, tiles, reach):
    """Distance of every point to the nearest point of another tile, infinity beyond twice a reach."""
    distances = np.full(len(points), np.inf)
    for tile in range(tiles.max() + 1):
        own = np.flatnonzero(tiles == tile)
        low, high = points[own].min(axis=0) - 2 * reach, points[own].max(axis=0) + 2 * reach
        others = np.flatnonzero((tiles != tile) & ((points > low) & (points < high)).all(axis=1))
        distances[own] = Neighbors(points[others]).query(points[own], 1)[0][:, 0]
    return distances


def row(points, whole, known, source, n_tiles, reduction):
    """One row of the table, and what the picture needs."""
    begin = perf_counter()
    target = source.with_name("thin.npy")
    result = lp.simplify_files(source, target, target_reduction=reduction, n_tiles=n_tiles)
    seconds = perf_counter() - begin
    kept = np.load(target)
    figures = lp.evaluate(points, kept, metrics=METRICS)
    halo = 4 * result.info["disk_radius"]
    tiles = tile_of(points, result.info["cuts"])
    distances = seam_distances(points, tiles, halo)
    mask = np.zeros(len(points), dtype=bool)
    mask[Neighbors(points).query(kept, 1)[1][:, 0]] = True
    near = distances <= halo
    ratio = {name: mask[some].sum() / whole[some].sum() for name, some in (("near", near), ("far", ~near))}
    values = {name: figures[name] / known[name] for name in COLUMNS}
    for i in range(4):
        strip = (distances > i * halo / 4) & (distances <= (i + 1) * halo / 4)
        values[f"strip_{i + 1}"] = mask[strip].sum() / whole[strip].sum()
    values |= {"near_over_far": ratio["near"] / ratio["far"], "share_near": near.mean()}
    values |= {"largest_residual": result.info["largest_residual"], "seconds": seconds}
    return {"tiles": n_tiles, "points": len(points), "kept": result.n_kept} | values, (
        tiles,
        distances,
        mask,
        halo,
    )


def picture(points, whole, tiles, distances, mask, halo):
    """Kept points around the middle of a seam, in tiles and as a whole."""
    mpl.use("Agg")
    import matplotlib.pyplot as plt

    seam = np.flatnonzero(distances < halo / 8)
    middle = points[seam[len(seam) // 2]]
    some = np.flatnonzero(np.linalg.norm(points - middle, axis=1) < 6 * halo)
    axes = np.linalg.svd(points[some] - points[some].mean(axis=0), full_matrices=False)[2][:2]
    flat = (points[some] - middle) @ axes.T
    figure, panels = plt.subplots(1, 2, figsize=(11, 5.5), sharex=True, sharey=True)
    for panel, chosen, title in zip(
        panels, (mask, whole), ("in tiles", "as a whole, in memory"), strict=True
    ):
        kept = chosen[some]
        panel.scatter(*flat[kept].T, c=tiles[some][kept] % 10, cmap="tab10", s=6)
        panel.set(title=title, aspect="equal", xticks=[], yticks=[])
    figure.tight_layout()
    figure.savefig(HERE.parents[1] / "docs" / "images" / "seam.png", dpi=80, bbox_inches="tight")


def main():
    """Measure, and write the table and the picture."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("mesh", type=Path)
    parser.add_argument("--points", type=int, default=1_000_000)
    parser.add_argument("--tiles", type=int, nargs="+", default=[32, 128])
    parser.add_argument("--reduction", type=float, default=0.9)
    given = parser.parse_args()
    points = resampled(given.mesh, given.points)
    begin = perf_counter()
    reference = lp.simplify(points, target_reduction=given.reduction)
    rows = [{"tiles": 0, "points": len(points), "kept": len(reference), "seconds": perf_counter() - begin}]
    rows[0]["largest_residual"] = reference.info["largest_residual"]
    whole = np.zeros(len(points), dtype=bool)
    whole[reference.indices] = True
    known = lp.evaluate(points, reference, metrics=METRICS)
    with tempfile.TemporaryDirectory() as folder:
        np.save(Path(folder) / "points.npy", points)
        for n_tiles in given.tiles:
            values, scene = row(points, whole, known, Path(folder) / "points.npy", n_tiles, given.reduction)
            rows.append(values)
            pd.DataFrame(rows).to_csv(HERE / f"seams-{given.points}.csv", index=False, float_format="%.4g")
            if n_tiles == given.tiles[0]:
                picture(points, whole, *scene)


if __name__ == "__main__":
    main()
