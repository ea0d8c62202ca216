"""Writes tiny.onnx: a network with the operators of an exported LPIPS and random weights.

Needs onnx, onnxruntime and numpy; the tests need none of them. Prints the outputs of onnxruntime
for the images of src/test_images.rs, which src/lpips/tests.rs has.
"""

import numpy as np
import onnx
import onnxruntime
from onnx import TensorProto, helper, numpy_helper

rng = np.random.default_rng(3)
constants, nodes = [], []


def constant(name, values, dtype=np.float32):
    constants.append(numpy_helper.from_array(np.asarray(values, dtype), name))
    return name


def node(kind, inputs, output, **attributes):
    nodes.append(helper.make_node(kind, inputs, [output], **attributes))
    return output


constant("shift", np.array([-0.03, -0.088, -0.188]).reshape(1, 3, 1, 1))
constant("scale", np.array([0.458, 0.448, 0.45]).reshape(1, 3, 1, 1))
constant("w1", rng.normal(0, 0.2, (6, 3, 5, 5)))
constant("b1", rng.normal(0, 0.1, 6))
constant("w2", rng.normal(0, 0.2, (8, 6, 3, 3)))
constant("b2", rng.normal(0, 0.1, 8))
constant("channels", [1], np.int64)
constant("epsilon", 1e-10)
constant("l1", np.abs(rng.normal(0, 0.3, (1, 6, 1, 1))))
constant("l2", np.abs(rng.normal(0, 0.3, (1, 8, 1, 1))))


def features(image):
    x = node("Div", [node("Sub", [image, "shift"], image + "s"), "scale"], image + "d")
    x = node("Conv", [x, "w1", "b1"], image + "c1", kernel_shape=[5, 5], strides=[2, 2], pads=[2, 2, 2, 2])
    first = node("Relu", [x], image + "r1")
    x = node("MaxPool", [first], image + "p", kernel_shape=[3, 3], strides=[2, 2])
    x = node("Conv", [x, "w2", "b2"], image + "c2", kernel_shape=[3, 3], pads=[1, 1, 1, 1])
    return [first, node("Relu", [x], image + "r2")]


def unit(x):
    two = node("Constant", [], x + "two", value=numpy_helper.from_array(np.float32(2)))
    squares = node("Pow", [x, two], x + "sq")
    length = node("Sqrt", [node("ReduceSum", [squares, "channels"], x + "sum", keepdims=1)], x + "len")
    return node("Div", [x, node("Add", [length, "epsilon"], x + "eps")], x + "unit")


parts = []
for k, (a, b) in enumerate(zip(features("in0"), features("in1")), 1):
    difference = node("Sub", [unit(a), unit(b)], f"diff{k}")
    squares = node("Mul", [difference, difference], f"square{k}")
    weighted = node("Conv", [squares, f"l{k}"], f"weighted{k}", kernel_shape=[1, 1])
    parts.append(node("ReduceMean", [weighted], f"mean{k}", axes=[2, 3], keepdims=1))
node("Add", parts, "distance")

image = lambda name: helper.make_tensor_value_info(name, TensorProto.FLOAT, [1, 3, "height", "width"])
out = helper.make_tensor_value_info("distance", TensorProto.FLOAT, [1, 1, 1, 1])
graph = helper.make_graph(nodes, "tiny", [image("in0"), image("in1")], [out], constants)
model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 13)], ir_version=8)
onnx.checker.check_model(model)
onnx.save(model, "tiny.onnx")


def tiles():
    y, x = np.mgrid[0:40, 0:48]
    a, b = np.zeros((40, 48, 3)), np.zeros((40, 48, 3))
    for c in range(3):
        a[..., c] = 7 * x + 13 * y + 29 * c + x * y % 11
        b[..., c] = a[..., c] + (x * x + 3 * y + c + 2) % 9
    inside = (x >= 6) & (x < 42) & (y >= 6) & (y < 34)
    return [np.where(inside[..., None], v % 64 / 64, 0) for v in (a, b)]


def smooth():
    y, x = np.mgrid[0:50, 0:60].astype(float)
    a = np.stack([x / 59, y / 49, (x + y) / 108], -1)
    b = a.copy()
    b[12:25, 15:30] *= 0.75
    b[25:, 30:, 2] = 1 - b[25:, 30:, 2]
    return [a, b]


session = onnxruntime.InferenceSession("tiny.onnx")
for name, images in [("tiles", tiles()), ("smooth", smooth())]:
    inputs = [(2 * image - 1).astype(np.float32).transpose(2, 0, 1)[None] for image in images]
    print(name, session.run(None, dict(zip(["in0", "in1"], inputs)))[0].item())
