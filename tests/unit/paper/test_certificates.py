"""Every cluster of three real scans is certified, at the paper's three rates and in both readings."""

import numpy as np
import pytest

from lpcompare.geometry.scale import normalize
from lpcompare.io.formats import read
from lpcompare.paper.certificate import TOLERANCE
from lpcompare.paper.clustering import cluster_points
from lpcompare.paper.curvature import estimate_curvature
from lpcompare.paper.features import feature_mask
from lpcompare.paper.program import SolverSettings
from lpcompare.paper.reduction import Reading, plan_clusters, reduce_clusters

N_CLUSTERS = 20


def residual(cloud, labels, task, chosen):
    """|D_cr - D_c| / D_c of eqs. 12 and 15, from the chosen points alone."""
    rows = np.intersect1d(task.candidates, chosen)
    centroid = cloud[labels == labels[rows[0]]].mean(axis=0)
    inverse = 1 / np.linalg.norm(cloud - centroid, axis=1)
    wanted = inverse[task.candidates].mean()
    return abs(inverse[rows].mean() - wanted) / wanted


@pytest.mark.shared
@pytest.mark.parametrize("file", ["stanford-bunny.obj", "igea.ply", "nefertiti.obj"])
def test_every_cluster_of_a_real_scan_is_certified(shared_models, file):
    cloud = normalize(read(shared_models / "upstream" / file).points)[0]
    labels = cluster_points(cloud, N_CLUSTERS, np.random.default_rng(0)).labels
    curvature = estimate_curvature(cloud).absolute
    features = feature_mask(curvature, labels)
    for reduction in (0.7, 0.8, 0.9):
        for reading in (Reading("lp_density"), Reading("lp_printed")):
            tasks = plan_clusters(
                cloud,
                labels,
                features,
                curvature,
                target_count=round((1 - reduction) * len(cloud)),
                rng=np.random.default_rng(0),
            )
            chosen, certificates = reduce_clusters(cloud, tasks, reading, SolverSettings())
            assert len(certificates) == N_CLUSTERS
            assert all(c.proven and c.status == "optimal" for c in certificates)
            if reading.method == "lp_density":
                worst = max(residual(cloud, labels, task, chosen) for task in tasks)
                assert worst <= TOLERANCE
            else:
                assert {c.proof for c in certificates} == {"sorting"}
