"""Makes thumbnails of `examples/README.md`: draw.py NAME=PICTURE... (SVG by Debian's Chromium, others by Pillow)."""

import io
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

WIDTH = 480  # px; they stand at 240


def read(path: Path) -> Image.Image:
    """The picture, of a film its middle."""
    if path.suffix != ".svg":
        image = Image.open(path)
        image.seek(getattr(image, "n_frames", 1) // 2)
        return image.convert("RGB")
    width, height = (re.search(rf"{side}=['\"]([\d.]+)", path.read_text()) for side in ("width", "height"))
    size = f"--window-size={width[1]},{height[1]}"
    with tempfile.NamedTemporaryFile(suffix=".png") as file:
        command = ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", size]
        subprocess.run([*command, f"--screenshot={file.name}", path.resolve().as_uri()], check=True, capture_output=True)
        return Image.open(io.BytesIO(Path(file.name).read_bytes())).convert("RGB")


for given in sys.argv[1:]:
    name, picture = given.split("=")
    image = read(Path(picture))
    image.thumbnail((WIDTH, WIDTH))
    image.save(Path(__file__).parent / f"{name}.webp", quality=75, method=6)
