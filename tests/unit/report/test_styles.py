"""Methods and stages can be told apart, on light and on dark."""

import pytest

from lpcompare.report.styles import method_styles, stage_styles

DARK_PANEL = "#1c1f25"
WHITE = "#ffffff"


def luminance(color):
    """Relative luminance after WCAG 2.2."""
    shares = [int(color[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [s / 12.92 if s <= 0.04045 else ((s + 0.055) / 1.055) ** 2.4 for s in shares]
    return sum(weight * value for weight, value in zip((0.2126, 0.7152, 0.0722), linear, strict=True))


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


def test_no_two_of_twelve_stages_share_a_colour():
    assert len({style.color for style in stage_styles(map(str, range(12))).values()}) == 12
