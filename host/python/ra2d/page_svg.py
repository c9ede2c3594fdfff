# SPDX-License-Identifier: BSD-3-Clause
"""Pictures within a page, as short SVG: whole numbers in tenths of a point, styles shared by all
pictures of the page, and colours as names that the page gives by day and by night."""
from __future__ import annotations

import base64
import colorsys
import io
import math
from collections.abc import Sequence
from typing import Any

import matplotlib
import matplotlib.colors
import numpy as np
import numpy.typing as npt
from markupsafe import Markup, escape
from matplotlib.backend_bases import RendererBase
from matplotlib.path import Path
from matplotlib.transforms import Affine2D
from PIL import Image

from .page_words import printable
from .style import BLACK, GREY, RC, SERIES, Picture

Points = npt.NDArray[np.int64]

DOTS = 10       # of the picture's units, to a point
FINEST = 10     # units along the axis, in which a line shows its lowest and its highest point alone
ANCHORS = {"left": ("", 0.0), "center": (";text-anchor:middle", 0.5),
           "right": (";text-anchor:end", 1.0)}
NAMES = dict(zip(SERIES, ("blue", "rust", "plum", "sky", "ink", "green", "amber", "moss"))) | {
    BLACK: "ink", GREY: "soft", "#ffffff": "paper"}


class Sheet:
    """Styles and colours of all pictures of a page, each with a short name."""

    def __init__(self) -> None:
        self._classes: dict[str, str] = {}
        self._colours: dict[str, str] = {}
        self.clips = 0

    def kind(self, style: str) -> str:
        """The class that has this style."""
        return self._classes.setdefault(style, f"p{len(self._classes)}")

    def colour(self, given: Any) -> str:
        """A colour as the page names it."""
        code = matplotlib.colors.to_hex(given)
        name = NAMES.get(code) or self._colours.setdefault(code, f"c{len(self._colours)}")
        return f"var(--{name})"

    def classes(self) -> Markup:
        return Markup("".join(f".{name}{{{style}}}" for style, name in self._classes.items()))

    def colours(self, dark: bool = False) -> Markup:
        """The colours that have no name in the page's own palette."""
        return Markup("".join(f"--{name}:{_for_dark(code) if dark else code};"
                              for code, name in self._colours.items()))


def _for_dark(code: str) -> str:
    """A lighter one of the same hue. Their order by lightness stays."""
    hue, lightness, saturation = colorsys.rgb_to_hls(*matplotlib.colors.to_rgb(code))
    return str(matplotlib.colors.to_hex(colorsys.hls_to_rgb(hue, 0.55 + 0.4 * lightness,
                                                            saturation)))


def _joined(numbers: Sequence[int]) -> str:
    """Numbers of a path: a minus separates, too."""
    return " ".join(map(str, numbers)).replace(" -", "-")


def _thinned(points: Points) -> Points:
    """A long line by its lowest and highest point in each small step along the axis."""
    if len(points) < 200:
        return points
    begins = np.flatnonzero(np.diff(points[:, 0] // FINEST, prepend=points[0, 0] // FINEST - 1))
    kept = []
    for first, beyond in zip(begins, [*begins[1:], len(points)]):
        heights = points[first:beyond, 1]
        kept += sorted({first + int(heights.argmin()), first + int(heights.argmax())})
    return points[kept]


def _straightened(points: Points) -> Points:
    """A line without the points that lie on it anyway, to half a unit."""
    kept = [points[0]]
    for point, after in zip(points[1:-1], points[2:]):
        (ax, ay), (bx, by) = point - kept[-1], after - kept[-1]
        if abs(ax * by - ay * bx) > 0.5 * math.hypot(bx, by) or ax * bx + ay * by < 0:
            kept.append(point)
    return np.array([*kept, points[-1]])


def _line(points: Points) -> str:
    """From the first point, which is the current one, to the others."""
    text, last = "", ""
    for dx, dy in np.diff(points, axis=0).tolist():
        if dx == dy == 0:
            continue
        word, numbers = ("v", [dy]) if dx == 0 else ("h", [dx]) if dy == 0 else ("l", [dx, dy])
        rest = _joined(numbers)
        text += word + rest if word != last else rest if rest[0] == "-" else " " + rest
        last = word
    return text


def _pieces(vertices: npt.NDArray[np.float64], codes: npt.NDArray[np.uint8] | None) -> str:
    """The commands of a path, each relative to the point before it."""
    points = np.rint(vertices).astype(np.int64)
    if codes is None:
        codes = np.full(len(points), Path.LINETO, dtype=np.uint8)
        codes[:1] = Path.MOVETO
    text, begin, at, i = "", np.zeros(2, np.int64), np.zeros(2, np.int64), 0
    while i < len(codes):
        code = codes[i]
        if code == Path.STOP:
            break
        if code == Path.LINETO:
            beyond = i + int(np.argmax(np.append(codes[i:] != Path.LINETO, True)))
            run = np.vstack([at[None], points[i:beyond]])
            text += _line(_straightened(_thinned(run)))
            at, i = points[beyond - 1], beyond
            continue
        count = {Path.CURVE3: 2, Path.CURVE4: 3}.get(code, 1)
        if code == Path.MOVETO:
            begin = points[i]
            text += "m" + _joined((begin - at).tolist())
            at = begin
        elif code == Path.CLOSEPOLY:
            text += "z"
            at = begin
        else:
            text += ("q" if count == 2
                     else "c") + _joined((points[i:i + count] - at).ravel().tolist())
            at = points[i + count - 1]
        i += count
    return text


class _Renderer(RendererBase):  # type: ignore[misc]
    """Matplotlib draws on it, and it writes short SVG."""

    def __init__(self, sheet: Sheet, width: float, height: float) -> None:
        super().__init__()
        self.sheet, self.width, self.height = sheet, width, height
        # class, clip and paths; or, with an empty class, a text
        self.parts: list[tuple[str, str, list[str]]] = []
        self.clips: dict[tuple[int, ...], str] = {}
        self.axis: list[int] = []  # where the parts of an axis begin: their order does not matter
        self.flipped = Affine2D().scale(1, -1).translate(0, height)

    def get_canvas_width_height(self) -> tuple[float, float]:
        return self.width, self.height

    def points_to_pixels(self, points: Any) -> Any:
        return points * DOTS

    def option_image_nocomposite(self) -> bool:
        return True

    def option_scale_image(self) -> bool:
        return True  # a map keeps its own pixels

    def open_group(self, s: str, gid: str | None = None) -> None:
        if s.startswith("matplotlib.axis"):
            self.axis.append(len(self.parts))

    def close_group(self, s: str) -> None:
        if s.startswith("matplotlib.axis"):
            self.axis.pop()

    def _style(self, gc: Any, face: Any) -> str:
        forced, style = gc.get_forced_alpha(), ""
        if face is not None and (len(face) < 4 or face[3] or forced):
            style += f";fill:{self.sheet.colour(face[:3])}"
            if len(face) == 4 and face[3] != 1 and not forced:
                style += f";fill-opacity:{face[3]:.2g}"
        if gc.get_linewidth() and (forced or gc.get_rgb()[3]):
            style += (f";stroke:{self.sheet.colour(gc.get_rgb()[:3])}"
                      f";stroke-width:{DOTS * gc.get_linewidth():.2g}")
            if gc.get_rgb()[3] != 1 and not forced:
                style += f";stroke-opacity:{gc.get_rgb()[3]:.2g}"
            start, dashes = gc.get_dashes()
            if dashes is not None:
                style += ";stroke-dasharray:" + " ".join(f"{DOTS * dash:.0f}" for dash in dashes)
        if style and forced and gc.get_alpha() != 1:
            style += f";opacity:{gc.get_alpha():.2g}"
        return style[1:]

    def _clip(self, gc: Any, places: npt.NDArray[np.float64]) -> str:
        """The name of the frame that cuts what is drawn; empty where it reaches nowhere beyond
        it."""
        box = gc.get_clip_rectangle()
        if box is None or not len(places):
            return ""
        x0, y0, x1, y1 = box.x0, self.height - box.y1, box.x1, self.height - box.y0
        if (places >= (x0 - 1, y0 - 1)).all() and (places <= (x1 + 1, y1 + 1)).all():
            return ""
        frame = tuple(round(value) for value in (x0, y0, x1, y1))
        if frame not in self.clips:
            self.sheet.clips += 1
            self.clips[frame] = f"k{self.sheet.clips}"
        return self.clips[frame]

    def _add(self, style: str, clip: str, path: str) -> None:
        """Joins paths of one style that follow one another, or belong to one axis."""
        if not path or not style:
            return
        kind = self.sheet.kind(style)
        for part in self.parts[self.axis[-1] if self.axis else -1:]:
            if part[:2] == (kind, clip):
                part[2].append(path)
                return
        self.parts.append((kind, clip, [path]))

    def draw_path(self, gc: Any, path: Any, transform: Any, rgbFace: Any = None) -> None:
        drawn = path.cleaned(transform + self.flipped, remove_nans=True, curves=True,
                             simplify=False)
        # far points are outside of the picture anyway
        held = drawn.vertices.clip(-8 * self.width, 8 * self.width)
        # the last one only ends the path
        ends = held[drawn.codes != Path.CLOSEPOLY][:-1] if len(held) > 1 else held
        self._add(self._style(gc, rgbFace), self._clip(gc, ends),
                  _pieces(held, drawn.codes).replace("m", "M", 1))

    def draw_markers(self, gc: Any, marker_path: Any, marker_trans: Any, path: Any, trans: Any,
                     rgbFace: Any = None) -> None:
        mark = marker_path.transformed(marker_trans + Affine2D().scale(1, -1))
        places = (trans + self.flipped).transform(path.vertices)
        places = places[np.isfinite(places).all(axis=1)].clip(-8 * self.width, 8 * self.width)
        clip, shape = self._clip(gc, places), _pieces(mark.vertices, mark.codes)
        styles = [self._style(gc, rgbFace)]
        is_circle = mark.codes is not None and (mark.codes == Path.CURVE4).sum() > 20
        if rgbFace is not None and is_circle:
            size, edge = 2 * float(mark.vertices[:, 0].max()), DOTS * gc.get_linewidth()
            shape = "h0"
            styles = [f"stroke:{self.sheet.colour(colour[:3])};stroke-width:{width:.0f}"
                      ";stroke-linecap:round"
                      for colour, width in ((gc.get_rgb(), size + edge), (rgbFace, size - edge))]
            if styles[0].split(";")[0] == styles[1].split(";")[0]:
                del styles[1]
        marks = "".join(f"M{_joined(place)}{shape}"
                        for place in np.rint(places).astype(int).tolist())
        for style in styles:
            self._add(style, clip, marks)

    def draw_image(self, gc: Any, x: float, y: float, im: Any, transform: Any = None) -> None:
        rows, columns = im.shape[:2]
        sized = (Affine2D().scale(1, 1) if transform is None
                 else Affine2D().scale(1 / columns, 1 / rows) + transform)
        placed = (sized + Affine2D().translate(x, y) + self.flipped).frozen().to_values()
        out = io.BytesIO()
        Image.fromarray(im[::-1]).convert("RGB").quantize(64).save(out, format="png", optimize=True)
        data = base64.b64encode(out.getvalue()).decode()
        a, b, c, d, e, f = placed
        flipped = (a, b, -c, -d, e + c * rows, f + d * rows)  # rows of a PNG go down
        matrix = " ".join(f"{number:.6g}" for number in flipped)
        self.parts.append(("", "",
                           [f'<image width="{columns}" height="{rows}" '
                            'style="image-rendering:pixelated" '
                            f'transform="matrix({matrix})" '
                            f'href="data:image/png;base64,{data}"/>']))

    def draw_text(self, gc: Any, x: float, y: float, s: str, prop: Any, angle: float,
                  ismath: Any = False,
                  mtext: Any = None) -> None:
        anchor, share = ANCHORS[mtext.get_horizontalalignment() if mtext is not None else "left"]
        along = share * self.get_text_width_height_descent(s, prop, ismath)[0]
        x += along * math.cos(math.radians(angle))
        y -= along * math.sin(math.radians(angle))
        style = (f"fill:{self.sheet.colour(gc.get_rgb()[:3])}"
                 f";font-size:{DOTS * prop.get_size_in_points():.0f}px{anchor}")
        if prop.get_weight() in ("bold", 700):
            style += ";font-weight:bold"
        turned = f' transform="rotate({-angle:.0f} {x:.0f} {y:.0f})"' if angle else ""
        text = _power(s) if ismath else escape(printable(s))
        self.parts.append(("", "",
                           [f'<text class="{self.sheet.kind(style)}" x="{x:.0f}" '
                            f'y="{y:.0f}"{turned}>'
                            f"{text}</text>"]))

    def picture(self, about: str) -> Markup:
        """The element, with a summary for those who cannot see it."""
        text = "".join(f'<clipPath id="{name}"><path d="M{x0} {y0}H{x1}V{y1}H{x0}"/></clipPath>'
                       for (x0, y0, x1, y1), name in self.clips.items())
        for kind, clip, paths in self.parts:
            cut = f' clip-path="url(#{clip})"' if clip else ""
            text += f'<path class="{kind}"{cut} d="{"".join(paths)}"/>' if kind else paths[0]
        return Markup(f'<svg viewBox="0 0 {self.width:.0f} {self.height:.0f}" role="img" '
                      f'aria-label="{escape(printable(about))}">{text}</svg>')


def _power(formula: str) -> Markup:
    """Numbers on axes of decades, the only formulas in a page's pictures."""
    plain = formula.replace("$", "").replace(r"\mathdefault",
                                             "").replace(r"\times",
                                                         "\u00d7").replace("{", "").replace(
        "}", "")
    base, _, power = plain.replace("-", "\u2212").partition("^")
    raised = Markup('<tspan dy="-.35em" font-size="75%">{}</tspan>').format(power) if power else ""
    return escape(base) + raised


def drawn(picture: Picture, sheet: Sheet, about: str) -> Markup:
    """A picture as an element of a page. `about`: what it shows, for those who cannot see it."""
    picture.set_dpi(72 * DOTS)
    width, height = (float(inches) * 72 * DOTS for inches in picture.get_size_inches())
    renderer = _Renderer(sheet, width, height)
    with matplotlib.rc_context(RC):
        for part in (picture, *picture.subfigs, *picture.axes):
            part.patch.set_visible(False)  # the page has its paper
        picture.draw(renderer)
    return renderer.picture(about)
