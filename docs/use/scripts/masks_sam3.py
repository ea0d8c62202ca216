"""Masks of a recording by SAM 3, from words.

    python masks_sam3.py toy --object "plush sloth" --hand "hand"

Writes toy/mask/CAMERA/object/NUMBER.png and toy/mask/CAMERA/hand/NUMBER.png: all that the words
describe, in every camera.
Needs SAM 3 (https://github.com/facebookresearch/sam3), access to its weights,
`pip install opencv-python-headless` and a CUDA device.
"""

import argparse
import tempfile
from pathlib import Path

import cv2
import numpy as np
from sam3.model_builder import build_sam3_video_predictor


def images_of(folder: Path) -> list[Path]:
    """The images of a camera, in the order of their numbers."""
    images = [path for path in folder.iterdir() if path.suffix.lower() in (".png", ".jpg", ".jpeg")]
    return sorted(images, key=lambda path: int("".join(c for c in path.stem if c.isdigit())))


def follow(predictor, frames: str, images: list[Path], words: str, out: Path) -> int:
    """Follows what the words describe through the images of a camera; returns the number of frames
    that show it."""
    start = {"type": "start_session", "resource_path": frames}
    session = predictor.handle_request(start)["session_id"]
    prompt = {"type": "add_prompt", "session_id": session, "frame_index": 0, "text": words}
    predictor.handle_request(prompt)
    out.mkdir(parents=True, exist_ok=True)
    seen = set()
    propagate = {"type": "propagate_in_video", "session_id": session}
    for answer in predictor.handle_stream_request(propagate):
        frame, masks = answer["frame_index"], np.asarray(answer["outputs"]["out_binary_masks"])
        if len(masks) > 0:
            mask = masks.any(axis=0).astype(np.uint8) * 255
            cv2.imwrite(str(out / f"{images[frame].stem}.png"), mask)
            seen.add(frame)
    predictor.handle_request({"type": "close_session", "session_id": session})
    return len(seen)


def main() -> None:
    """Makes the masks of all cameras."""
    form = argparse.RawTextHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("recording", type=Path)
    parser.add_argument("--object", required=True, help="words for the soft object")
    parser.add_argument("--hand", default="hand", help="words for the hand or gripper")
    options = parser.parse_args()

    predictor = build_sam3_video_predictor()
    for folder in sorted((options.recording / "color").iterdir()):
        images = images_of(folder)
        with tempfile.TemporaryDirectory() as frames:
            # The predictor reads JPEG files that are named by number.
            for index, path in enumerate(images):
                quality = [cv2.IMWRITE_JPEG_QUALITY, 95]
                cv2.imwrite(f"{frames}/{index}.jpg", cv2.imread(str(path)), quality)
            for part in ("object", "hand"):
                out = options.recording / "mask" / folder.name / part
                count = follow(predictor, frames, images, getattr(options, part), out)
                print(f"camera {folder.name}: {part} in {count} of {len(images)} frames")


if __name__ == "__main__":
    main()
