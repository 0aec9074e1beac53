"""The style of all pictures: palette, settings of matplotlib, curves with few points, formats, saving."""
import argparse
import math

# Okabe and Ito's palette: distinguishable with any colour vision, and by lightness in print.
BLUE, ORANGE, GREEN, PURPLE, BLACK = "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#000000"
WANTED = {"linestyle": (0, (4, 2)), "linewidth": 1.2, "zorder": 3}  # references and theory, drawn over the traces that follow them
VERDICTS = {  # sign, class and meaning of a verdict; the sign is for readers who do not see the colour
    "reproduced": ("✓", "good", "agrees with the paper's number within the tolerance"),
    "reproduced in kind": ("≈", "kind", "the behaviour is the paper's; the number differs or the print has none"),
    "not reproduced": ("✗", "bad", "the paper's statement was not found"),
    "holds": ("✓", "good", "a claim beyond the paper that our runs confirm"),
    "does not hold": ("✗", "bad", "a claim beyond the paper that our runs refute"),
}
MISSING = "matplotlib is missing: run tools/setup demo, or install python3-matplotlib"


def pyplot(**settings):
    """matplotlib's pyplot in the style of this project, with additional `settings`; ImportError if it is missing."""
    import matplotlib
    matplotlib.use("Agg")
    matplotlib.rcParams.update({
        "font.size": 9, "axes.grid": True, "grid.color": "#DDDDDD", "grid.linewidth": 0.6, "axes.axisbelow": True,
        "axes.spines.top": False, "axes.spines.right": False, "axes.linewidth": 0.8, "lines.linewidth": 1.1,
        "legend.frameon": False, "svg.hashsalt": "lagless", "svg.fonttype": "path", **settings,
    })
    from matplotlib import pyplot as module
    return module


def outline(time, values, most=4000):
    """The same curve with fewer points: the smallest and the largest value of each section, so that no peak is lost, and every gap
    (NaN)."""
    count = len(time)
    if count <= most:
        return time, values
    gaps = [index for index in range(count) if values[index] != values[index]]
    kept = {0, count - 1, *gaps}
    gaps = set(gaps)
    stretch = math.ceil(2 * count / most)
    for begin in range(0, count, stretch):
        indices = [index for index in range(begin, min(begin + stretch, count)) if index not in gaps]
        if indices:
            kept.add(min(indices, key=values.__getitem__))
            kept.add(max(indices, key=values.__getitem__))
    order = sorted(kept)
    return [time[i] for i in order], [values[i] for i in order]


FORMATS = ("html", "png", "svg")


def formats(text):
    """The formats of an option `--format html,png`, for argparse."""
    words = text.split(",")
    if not set(words) <= set(FORMATS):
        raise argparse.ArgumentTypeError(f"{text}: accepted: html, png, svg, separated by commas")
    return words


def save_as(figure, path):
    """Writes the PNG or the SVG that the name of the file has as its ending. Each call writes the same octets."""
    figure.savefig(path, metadata={"Software": None} if path.suffix == ".png" else {"Date": None})


def save(figure, png):
    """Writes a PNG, and the same picture as SVG in the same folder. Each call writes the same octets. OSError if a file cannot be
    written."""
    png.parent.mkdir(parents=True, exist_ok=True)
    save_as(figure, png)
    save_as(figure, png.with_suffix(".svg"))
