"""Masks of a recording by SAM 2, from clicks in its first frames.

    python masks_sam2.py toy --object 0:420,250 --hand 0:610,90 --object 1:300,240 --hand 1:200,80

CAMERA:X,Y are pixels in frame 0, counted from the upper left; every camera needs a click for each
part that it sees.
Writes toy/mask/CAMERA/object/NUMBER.png and toy/mask/CAMERA/hand/NUMBER.png.
Needs `pip install sam2 huggingface_hub opencv-python-headless` and a CUDA device.
"""

import argparse
import tempfile
from pathlib import Path

import cv2
import numpy as np
import torch
from sam2.sam2_video_predictor import SAM2VideoPredictor

PARTS = {1: "object", 2: "hand"}


def click(text: str) -> tuple[int, list[float]]:
    """Reads CAMERA:X,Y."""
    camera, place = text.split(":")
    return int(camera), [float(x) for x in place.split(",")]


def images_of(folder: Path) -> list[Path]:
    """The images of a camera, in the order of their numbers."""
    images = [path for path in folder.iterdir() if path.suffix.lower() in (".png", ".jpg", ".jpeg")]
    return sorted(images, key=lambda path: int("".join(c for c in path.stem if c.isdigit())))


def follow(predictor, images: list[Path], clicks: dict[int, list[list[float]]], out: Path) -> None:
    """Follows the parts that were clicked in frame 0 through all images of a camera."""
    with tempfile.TemporaryDirectory() as frames:
        # The predictor reads JPEG files that are named by number.
        for index, path in enumerate(images):
            quality = [cv2.IMWRITE_JPEG_QUALITY, 95]
            cv2.imwrite(f"{frames}/{index:05}.jpg", cv2.imread(str(path)), quality)
        state = predictor.init_state(frames)
        for part, points in clicks.items():
            predictor.add_new_points_or_box(
                state,
                frame_idx=0,
                obj_id=part,
                points=np.array(points, dtype=np.float32),
                labels=np.ones(len(points), dtype=np.int32),
            )
        for frame, parts, scores in predictor.propagate_in_video(state):
            for part, score in zip(parts, scores, strict=True):
                file = out / PARTS[part] / f"{images[frame].stem}.png"
                file.parent.mkdir(parents=True, exist_ok=True)
                mask = (score[0] > 0).cpu().numpy().astype(np.uint8) * 255
                cv2.imwrite(str(file), mask)


def main() -> None:
    """Makes the masks of all cameras."""
    form = argparse.RawTextHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("recording", type=Path)
    for part in PARTS.values():
        many = {"action": "append", "default": [], "metavar": "CAMERA:X,Y"}
        parser.add_argument(f"--{part}", type=click, **many)
    parser.add_argument("--model", default="facebook/sam2.1-hiera-large")
    options = parser.parse_args()

    predictor = SAM2VideoPredictor.from_pretrained(options.model)
    for folder in sorted((options.recording / "color").iterdir()):
        camera = int(folder.name)
        clicks: dict[int, list[list[float]]] = {}
        for part, name in PARTS.items():
            places = [place for where, place in getattr(options, name) if where == camera]
            if places:
                clicks[part] = places
        if not clicks:
            print(f"camera {camera} has no click: it gets no masks")
            continue
        with torch.inference_mode(), torch.autocast("cuda", dtype=torch.bfloat16):
            follow(predictor, images_of(folder), clicks, options.recording / "mask" / folder.name)
        print(f"camera {camera}: done")


if __name__ == "__main__":
    main()
