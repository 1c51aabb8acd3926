"""One or more small sound files of every format, of a run and of a study: what is damaged afterwards."""

import json
import struct
from collections.abc import Mapping

import laspy
import lzf
import numpy as np
import pymeshlab

from lpcompare.io import write
from lpcompare.types import PointCloud

N = 40
MESHLAB = (".3ds", ".ctm", ".dae", ".e57", ".stl", ".wrl", ".x3d")


def samples(folder):
    """The content of the files by their names; a study and a run have the endings .toml and .json."""
    cloud = _cloud()
    for suffix in (
        ".ply",
        ".obj",
        ".off",
        ".xyz",
        ".txt",
        ".asc",
        ".csv",
        ".npy",
        ".npz",
        ".pcd",
        ".las",
        ".laz",
    ):
        write(folder / f"a{suffix}", cloud)
    layers = pymeshlab.MeshSet()
    layers.add_mesh(pymeshlab.Mesh(cloud.points, cloud.faces, v_color_matrix=cloud.colors))
    for suffix in MESHLAB:
        layers.save_current_mesh(str(folder / f"a{suffix}"))
    for kind in range(11):
        header = laspy.LasHeader(version="1.4", point_format=kind)
        file = laspy.LasData(header)
        file.x, file.y, file.z = cloud.points.T
        file.evlrs = laspy.vlrs.vlrlist.VLRList([laspy.VLR("lab", 7, "a note", b"12345")])
        file.write(str(folder / f"kind{kind}.laz"))
        file.write(str(folder / f"kind{kind}.las"))
    made = {path.name: path.read_bytes() for path in sorted(folder.iterdir())}
    return made | _by_hand(cloud)


def _cloud():
    rng = np.random.default_rng(3)
    return PointCloud(
        rng.normal(size=(N, 3)) + np.array([500, 4000, 10]),
        normals=rng.normal(size=(N, 3)),
        colors=rng.integers(0, 256, (N, 4)) / 255,
        attributes={"label": rng.integers(0, 9, N).astype("u1"), "time": rng.normal(size=N)},
        faces=np.arange(N - N % 3).reshape(-1, 3),
    )


def _by_hand(cloud: PointCloud) -> Mapping[str, bytes]:
    rows = "".join(f"{x:.3f} {y:.3f} {z:.3f} 0.5 255 0 7\n" for x, y, z in cloud.points)
    points = "".join(f"{x:.3f} {y:.3f} {z:.3f}\n" for x, y, z in cloud.points)
    axes = "property float x\nproperty float y\nproperty float z\n"
    vertex = f"element vertex {N}\n{axes}property list uchar int near\n"
    near = "".join(f"{line} {i % 4}{' 7' * (i % 4)}\n" for i, line in enumerate(points.splitlines()))
    faces = "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
    pose = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"
    table = np.zeros(N, "<f4, <f4, <f4, <f4, <u1")
    for i in range(3):
        table[f"f{i}"] = cloud.points[:, i]
    planes = b"".join(np.ascontiguousarray(table[name]).tobytes() for name in table.dtype.names)
    packed = lzf.compress(planes)
    head = (
        "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z rgb ring\nSIZE 4 4 4 4 1\nTYPE F F F F U\nCOUNT 1 1 1 1 1\n"
        f"WIDTH {N // 2}\nHEIGHT 2\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {N}\nDATA "
    )
    expe = "property position 3 r32\nproperty normal 3 r32\nproperty color 4 ui8\ndata\n"
    row = np.arange(6, dtype="<f4").tobytes() + b"\1\2\3\xff"
    buffer = np.eye(3, dtype="<f4").tobytes() + np.arange(4, dtype="<u2").tobytes()
    texts = {
        "lists.ply": f"ply\nformat ascii 1.0\ncomment a\n{vertex}{faces}{near}3 0 1 2\n4 0 1 2 3\n",
        "a.pts": f"{N}\n{rows}",
        "a.ptx": f"{N // 2}\n2\n{pose}{rows}" * 2,
        "names.csv": '"id","X","Y","Z","a, b"\n' + "".join(f'{i},{i},2,3,"x"\n' for i in range(N)),
        "semicolons.csv": "x;y;z;Intensity\n" + "1.5;2.5;3.5;\n" * N,
        "normals.obj": "".join(f"v {p}\nvn 0 0 1\n" for p in points.splitlines())
        + "f 1//2 2//1 -1//-1 4//4\n",
        "normals.off": f"NCOFF\n{N} 1 0\n" + rows.replace("0.5 255", "0 0 1 255") + "3 0 1 2\n",
        "text.pcd": head + "ascii\n" + "".join(f"{line} 4.2e6 3\n" for line in points.splitlines()),
        "text.stl": "solid a\n"
        + "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n" * 3
        + "endsolid a\n",
        "a.x3dv": "#X3D V3.0 utf8\nShape { geometry IndexedFaceSet { coordIndex [0 1 2 -1]\n"
        "coord Coordinate { point [0 0 0, 1 0 0, 0 1 0] } } }\n",
        "a.study.toml": 'title = "t"\nmodels = ["bunny"]\nmethods = ["lp_density"]\nreductions = [0.7, 0.9]\n'
        "seeds = [0, 1]\n[settings.lp_density]\nn_clusters = [10, 25]\n[perturbations]\nnoise = [0.1]\n",
    }
    return {name: text.encode() for name, text in texts.items()} | {
        "big.ply": f"ply\nformat binary_big_endian 1.0\nelement vertex {N}\n{axes}{faces}".encode()
        + cloud.points.astype(">f4").tobytes()
        + struct.pack(">B3iB4i", 3, 0, 1, 2, 4, 0, 1, 2, 3),
        "compressed.pcd": head.encode()
        + b"binary_compressed\n"
        + struct.pack("<II", len(packed), len(planes))
        + packed,
        "binary.apts": f"[Expe/PointSet/Binary/0.2]\nnofpoints {N}\n{expe}".encode() + row * N,
        "text.apts": b"[Expe/PointSet/Ascii/0.2]\nnofpoints 9\nproperty position 3 r32\nproperty radius 1 r32\ndata\n"
        + b"(1, 2, 3);4\n" * 9,
        "a.tri": b"LE"
        + struct.pack("<3i", N, 1, 0)
        + cloud.points.astype("<f4").tobytes()
        + struct.pack("<3i", 0, 1, 2),
        "a.glb": _glb(buffer),
        "a.gltf": json.dumps(_gltf(len(buffer)) | {"buffers": [{"uri": "b.bin", "byteLength": 44}]}).encode(),
        "b.bin": buffer,
    }


def _gltf(n_bytes: int) -> dict[str, object]:
    return {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": n_bytes}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 36},
            {"buffer": 0, "byteOffset": 36, "byteLength": 6},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"},
        ],
    }


def _glb(buffer: bytes) -> bytes:
    text = json.dumps(_gltf(len(buffer))).encode()
    text += b" " * (-len(text) % 4)
    chunks = (
        struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(buffer), b"BIN\0") + buffer
    )
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks
