"""Methods and stages can be told apart, on light and on dark."""

from itertools import combinations

import numpy as np
import pytest

from lpcompare.report.styles import method_styles, stage_styles

DARK_PANEL = "#1c1f25"
WHITE = "#ffffff"


TO_XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
"""From linear sRGB (IEC 61966-2-1)."""


def xyz(color):
    shares = np.array([int(color[i : i + 2], 16) / 255 for i in (1, 3, 5)])
    return TO_XYZ @ np.where(shares <= 0.04045, shares / 12.92, ((shares + 0.055) / 1.055) ** 2.4)


def luminance(color):
    """Relative luminance after WCAG 2.2."""
    return xyz(color)[1]


def lab(color):
    """CIE L*a*b* at D65; no colour here is so dark that the linear foot of the curve is reached."""
    x, y, z = np.cbrt(xyz(color) / TO_XYZ.sum(axis=1))
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def contrast(first, second):
    low, high = sorted((luminance(first), luminance(second)))
    return (high + 0.05) / (low + 0.05)


STYLES = method_styles(map(str, range(84)))


def test_no_two_of_84_methods_look_the_same():
    assert len({(style.color, style.symbol) for style in STYLES.values()}) == 84
    assert len({(style.dark, style.symbol) for style in STYLES.values()}) == 84


@pytest.mark.parametrize("color", sorted({style.dark for style in STYLES.values()}))
def test_every_colour_stands_out_on_a_dark_page(color):
    assert contrast(color, DARK_PANEL) >= 3


@pytest.mark.parametrize("color", sorted({style.color for style in STYLES.values()}))
def test_every_colour_is_seen_on_a_light_page(color):
    assert contrast(color, WHITE) >= 2.2


@pytest.mark.parametrize("scheme", ["color", "dark"])
def test_no_two_colours_lie_near_each_other(scheme):
    found = sorted({getattr(style, scheme) for style in STYLES.values()})
    assert min(np.linalg.norm(lab(a) - lab(b)) for a, b in combinations(found, 2)) > 15


def test_no_two_of_twelve_stages_share_a_colour():
    assert len({style.color for style in stage_styles(map(str, range(12))).values()}) == 12
