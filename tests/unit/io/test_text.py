"""Text of other programs: what separates the columns, which line names them, and that the names decide."""

import numpy as np
import pytest

from lpcompare.errors import InputError
from lpcompare.io import keep_rows, read, write
from lpcompare.types import PointCloud

NAN = float("nan")
HALF = [[1.5, 2.5, 3.5]]
DIALECTS = {
    "pandas, with its index": ("a.csv", ",x,y,z\n0,1.5,2.5,3.5\n", {"column_1": [0.0]}),
    "an empty cell": ("a.csv", "id,label,x,y,z\n1,,1.5,2.5,3.5\n", {"id": [1.0], "label": [NAN]}),
    "names that differ in case": (
        "a.csv",
        "label,x,y,z,Label\n7,1.5,2.5,3.5,1\n",
        {"label": [7.0], "Label": [1.0]},
    ),
    "a name twice": ("a.csv", "x,y,z,a,a\n1.5,2.5,3.5,4,5\n", {"a": [4.0], "a_2": [5.0]}),
    "x beside X": ("a.csv", "X,x,y,z\n9,1.5,2.5,3.5\n", {"X": [9.0]}),
    "CloudCompare": ("a.asc", "//X Y Z Intensity\n1.5 2.5 3.5 0.5\n", {"Intensity": [0.5]}),
    "CloudCompare, commas": ("a.txt", "//X,Y,Z,Scalar_field\n1.5,2.5,3.5,4\n", {"Scalar_field": [4.0]}),
    "CloudCompare, a count": ("a.txt", "1\n1.5 2.5 3.5\n", {}),
    "VeloView": (
        "a.csv",
        '"intensity","Points_m_XYZ:0","Points_m_XYZ:1","Points_m_XYZ:2","laser_id"\n4,1.5,2.5,3.5,7\n',
        {"intensity": [4.0], "laser_id": [7.0]},
    ),
    "ParaView": ("a.csv", '"Points:0","Points:1","Points:2"\n1.5,2.5,3.5\n', {}),
    "Excel": ("a.csv", "x;y;z;Höhe\n1.5;2.5;3.5;1\n", {"Höhe": [1.0]}),
    "Excel, byte order mark": ("a.csv", "\ufeffx;y;z\r\n1.5;2.5;3.5\r\n", {}),
    "Riegl, tabs": ("a.txt", "X\tY\tZ\tAmplitude\n1.5\t2.5\t3.5\t20.5\n", {"Amplitude": [20.5]}),
    "Riegl, units": ("a.csv", "X[m],Y[m],Z[m],Amplitude[dB]\n1.5,2.5,3.5,20.5\n", {"Amplitude[dB]": [20.5]}),
    "coordinates of a survey": ("a.csv", "Easting,Northing,Height,code\n1.5,2.5,3.5,4\n", {"code": [4.0]}),
    "X_coord": ("a.csv", "X_coord,Y_coord,Z_coord\n1.5,2.5,3.5\n", {}),
    "quotes": ("a.csv", '"X","Y","Z","a, b"\n"1.5","2.5","3.5","4"\n', {"a, b": [4.0]}),
    "words": ("a.csv", "label,x,y,z\ntree,1.5,2.5,3.5\n", {"label": ["tree"]}),
    "R, with row names": ("a.txt", '"x" "y" "z"\n"1" 1.5 2.5 3.5\n', {"column_1": [1.0]}),
    "a separator behind each row": ("a.csv", "x,y,z\n1.5,2.5,3.5,\n", {}),
    "commas and spaces": ("a.xyz", "1.5, 2.5, 3.5\n", {}),
    "Matlab": ("a.txt", "% x y z\n1.5 2.5 3.5\n", {}),
    "CloudCompare, names then another comment": (
        "a.asc",
        "//Intensity X Y Z\n//made by hand\n0.5 1.5 2.5 3.5\n",
        {"Intensity": [0.5]},
    ),
    "RiSCAN": (
        "a.asc",
        "# Reflectance[dB] X[m] Y[m] Z[m]\n# end\n-3 1.5 2.5 3.5\n",
        {"Reflectance[dB]": [-3.0]},
    ),
    "names behind a word": ("a.txt", "# columns: z i y x\n3.5 4 2.5 1.5\n", {"i": [4.0]}),
    "a comment of fewer names": ("a.txt", "# x y z\n1.5 2.5 3.5 4\n", {"column_4": [4.0]}),
    "a name that begins as a number": ("a.csv", "Infrared,x,y,z\n4,1.5,2.5,3.5\n", {"Infrared": [4.0]}),
    "a name that begins with a digit": ("a.csv", "2theta;x;y;z\n4;1.5;2.5;3.5\n", {"2theta": [4.0]}),
    "Excel, its line of the separator": ("a.csv", "sep=;\r\nx;y;z\r\n1.5;2.5;3.5\r\n", {}),
    "dates": (
        "a.csv",
        "time,x,y,z\n2024-01-01 12:00:00,1.5,2.5,3.5\n",
        {"time": ["2024-01-01 12:00:00"]},
    ),
    "dates, tabs": ("a.txt", "x\ty\tz\ttime\n1.5\t2.5\t3.5\t1.2.24 12:00\n", {"time": ["1.2.24 12:00"]}),
    "words with commas": ("a.csv", "x;y;z;note\n1.5;2.5;3.5;tree, old\n", {"note": ["tree, old"]}),
    "numbers that no integer holds": ("a.csv", f"x,y,z,id\n1.5,2.5,3.5,{2**64}\n", {"id": [str(2**64)]}),
    "large numbers": ("a.csv", f"x,y,z,id\n1.5,2.5,3.5,{2**53 + 1}\n", {"id": [2**53 + 1]}),
}


@pytest.mark.parametrize("name", DIALECTS)
def test_dialects(name, tmp_path):
    file, text, attributes = DIALECTS[name]
    (tmp_path / file).write_text(text, encoding="utf-8")
    cloud = read(tmp_path / file)
    assert cloud.points.tolist() == HALF
    assert repr({k: v.tolist() for k, v in cloud.attributes.items()}) == repr(attributes)
    keep_rows(tmp_path / file, tmp_path / f"b{file}", np.array([0]))
    assert (tmp_path / f"b{file}").read_bytes() == (tmp_path / file).read_bytes()


def test_latin_1(tmp_path):
    (tmp_path / "a.csv").write_bytes("x;y;z;Größe\n1;2;3;4\n".encode("latin-1"))
    assert read(tmp_path / "a.csv").attributes["Größe"].tolist() == [4]


def test_colours_and_normals_by_name(tmp_path):
    text = "//X Y Z R G B Nx Ny Nz\n1 2 3 255 0 51 0 0 1\n1 2 4 1 2 3 0 1 0\n"
    (tmp_path / "a.asc").write_text(text)
    cloud = read(tmp_path / "a.asc")
    assert cloud.colors.tolist()[0] == [1, 0, 0.2, 1]
    assert cloud.normals.tolist() == [[0, 0, 1], [0, 1, 0]]


def test_leica_pts_have_an_intensity_and_colours(tmp_path):
    (tmp_path / "a.pts").write_text("2\n1 2 3 -1200 255 0 51\n1 2 4 100 1 2 3\n")
    cloud = read(tmp_path / "a.pts")
    assert cloud.attributes["intensity"].tolist() == [-1200, 100]
    assert cloud.colors.tolist()[0] == [1, 0, 0.2, 1]


@pytest.mark.parametrize("suffix", [".xyz", ".txt", ".csv"])
def test_our_own_text_gives_normals_and_colours_back(suffix, tmp_path):
    cloud = PointCloud(np.eye(3), normals=np.eye(3), colors=np.full((3, 4), [1, 0.5, 0.2, 1]))
    assert write(tmp_path / f"a{suffix}", cloud) == ()
    again = read(tmp_path / f"a{suffix}")
    assert np.array_equal(again.normals, cloud.normals)
    assert np.array_equal(again.colors, cloud.colors)
    write(tmp_path / "a.ply", again)
    head = (tmp_path / "a.ply").read_bytes().partition(b"end_header")[0]
    assert b"property double nx" in head
    assert b"property uchar red" in head


@pytest.mark.parametrize(
    ("name", "text", "reason"),
    [
        ("a.csv", "x;y;z\n1,5;2,5;3,5\n", "decimal commas, or marks between thousands; export it"),
        ("a.csv", "x;y;z\n1;2;3\n1,5;2;3\n", "decimal commas"),
        ("a.csv", '"x","y","z"\n"1,5","2,5","3,5"\n', "decimal commas"),
        ("a.txt", "1,5\t2,5\t3,5\n", "decimal commas"),
        ("a.txt", "1 2 3,5\n4 5 6,5\n", "decimal commas"),
        ("a.txt", "# x y z a\n1 2 3,5\n4 5 6,5\n", "decimal commas"),
        ("a.txt", "1,234.5 2,345.5 7.0\n", "marks between thousands"),
        ("a.csv", "1 234.5;2 345.5;7.0\n", "is separated in two ways"),
        ("a.csv", "x;y;z\n1 234.5;2 345.5;7.0\n", "'x' is not made of numbers"),
        (
            "a.csv",
            "# t (ns), X1 (m), Y1 (m), Z1 (m)\n9, 1, 2, 3\n",
            "none of its columns are named x, y and z",
        ),
        ("a.csv", "x,x,y,z\n9,1,2,3\n", "more than one column 'x'"),
        ("a.csv", "a,b,c\n1,2,3\n", "none of its columns are named x, y and z, only 'a', 'b', 'c'"),
        ("a.csv", "x,y,h\n1,2,3\n", "none of its columns are named x, y and z"),
        ("a.csv", "X,x,y,Z\n1,2,3,4\n", "none of its columns are named x, y and z"),
        ("a.csv", "x,y,z\nlow,2,3\n", "'x' is not made of numbers"),
        ("a.txt", "A scan of my room\n1 2 3\n", "does not fit its rows of 3 columns"),
        ("a.csv", "x,y,z,i\n1,2,3\n", "does not fit its rows of 3 columns"),
        ("a.csv", "x,y,z\n1,2,3\n4,5\n", "has 2 columns, not 3"),
        ("a.xyz", "2\nwater\nO 0 0 0\nH 1 0 0\n", "line 3 is b'O 0 0 0', not numbers"),
        ("a.xyz", "1_0 2 3\n", "'x' is not made of numbers"),
        ("a.pts", "1.5\n1 2 3\n", "is no number of points"),
    ],
)
def test_refusals(name, text, reason, tmp_path):
    (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=reason):
        read(tmp_path / name)


def test_utf_16_is_refused(tmp_path):
    (tmp_path / "a.txt").write_text("x y z\n1 2 3\n", encoding="utf-16")
    with pytest.raises(InputError, match="UTF-16; save it as UTF-8"):
        read(tmp_path / "a.txt")
