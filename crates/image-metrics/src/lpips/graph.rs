//! A network as a list of operators in the order of their computation.

use std::collections::{HashMap, HashSet};

use prost::Message;

use super::{
    Error,
    arithmetic::{broadcast, reduce},
    convolution::{Windows, conv, max_pool},
    onnx::{AttributeMessage, Model, NodeMessage},
    tensor::Tensor,
};

/// A network of two images.
pub(super) struct Graph {
    constants: HashMap<String, Tensor>,
    nodes: Vec<Node>,
    inputs: [String; 2],
    output: String,
}

struct Node {
    operator: Operator,
    inputs: Vec<String>,
    output: String,
}

enum Operator {
    Add,
    Sub,
    Mul,
    Div,
    Pow,
    Sqrt,
    Relu,
    Identity,
    Conv(Windows),
    MaxPool([usize; 2], Windows),
    Reduce { axes: Vec<i64>, keep: bool, mean: bool },
}

impl Graph {
    /// Network of a file's content.
    pub(super) fn decode(bytes: &[u8]) -> Result<Self, Error> {
        let model = Model::decode(bytes).map_err(|e| Error::Format(e.to_string()))?;
        let graph = model.graph.ok_or_else(|| Error::Format("it has no graph".into()))?;
        let mut constants = HashMap::new();
        for message in &graph.initializer {
            constants.insert(message.name.clone(), Tensor::of(message)?);
        }
        let mut nodes = Vec::new();
        for message in &graph.node {
            let [output] = &message.output[..] else {
                return Err(Error::operator(&message.op_type, " with several outputs"));
            };
            if message.op_type == "Constant" {
                let tensor = attribute(message, "value").and_then(|a| a.t.as_ref());
                let tensor =
                    tensor.ok_or_else(|| Error::operator("Constant", " without a tensor"))?;
                constants.insert(output.clone(), Tensor::of(tensor)?);
            } else {
                let (inputs, output) = (message.input.clone(), output.clone());
                nodes.push(Node { operator: Operator::of(message)?, inputs, output });
            }
        }
        // Exporters may list constants as inputs too.
        let names = graph.input.into_iter().map(|v| v.name);
        let inputs: Vec<String> = names.filter(|n| !constants.contains_key(n)).collect();
        let found = inputs.len();
        let inputs = inputs.try_into().map_err(|_| {
            Error::Format(format!("it has {found} inputs instead of the two images of lpips.LPIPS"))
        })?;
        let [output] = &graph.output[..] else {
            return Err(Error::Format(format!(
                "it has {} outputs instead of one",
                graph.output.len()
            )));
        };
        Ok(Self { constants, nodes, inputs, output: output.name.clone() })
    }

    /// Output for two images.
    pub(super) fn run(&self, images: [Tensor; 2]) -> Result<Tensor, Error> {
        let mut values: HashMap<&str, Tensor> =
            self.inputs.iter().map(String::as_str).zip(images).collect();
        for (index, node) in self.nodes.iter().enumerate() {
            let output = self.compute(node, &values)?;
            values.insert(&node.output, output);
            // Values that no later node reads need not stay in memory.
            let rest = &self.nodes[index + 1..];
            let needed: HashSet<&str> = rest
                .iter()
                .flat_map(|n| &n.inputs)
                .chain([&self.output])
                .map(String::as_str)
                .collect();
            values.retain(|name, _| needed.contains(name));
        }
        values.remove(self.output.as_str()).ok_or_else(|| missing(&self.output))
    }

    fn compute(&self, node: &Node, values: &HashMap<&str, Tensor>) -> Result<Tensor, Error> {
        let optional = |i: usize| node.inputs.get(i).filter(|name| !name.is_empty());
        let find = |name: &String| {
            let found = values.get(name.as_str()).or_else(|| self.constants.get(name));
            found.ok_or_else(|| missing(name))
        };
        let input = |i: usize| optional(i).ok_or_else(|| missing("an input")).and_then(find);
        let x = input(0)?;
        let map = |value: fn(f32) -> f32| Tensor {
            shape: x.shape.clone(),
            values: x.values.iter().map(|v| value(*v)).collect(),
        };
        match &node.operator {
            Operator::Add => broadcast(x, input(1)?, |a, b| a + b),
            Operator::Sub => broadcast(x, input(1)?, |a, b| a - b),
            Operator::Mul => broadcast(x, input(1)?, |a, b| a * b),
            Operator::Div => broadcast(x, input(1)?, |a, b| a / b),
            Operator::Pow => broadcast(x, input(1)?, f32::powf),
            Operator::Sqrt => Ok(map(f32::sqrt)),
            Operator::Relu => Ok(map(|v| v.max(0.0))),
            Operator::Identity => Ok(x.clone()),
            Operator::Conv(windows) => {
                conv(x, input(1)?, optional(2).map(find).transpose()?, *windows)
            }
            Operator::MaxPool(kernel, windows) => max_pool(x, *kernel, *windows),
            Operator::Reduce { axes, keep, mean } => {
                // Since opset 13 or 18 the axes are an input.
                let given = optional(1).map(find).transpose()?;
                let given = given.map(|t| t.values.iter().map(|v| *v as i64).collect::<Vec<_>>());
                reduce(x, given.as_ref().unwrap_or(axes), *keep, *mean)
            }
        }
    }
}

impl Operator {
    fn of(message: &NodeMessage) -> Result<Self, Error> {
        if !matches!(message.domain.as_str(), "" | "ai.onnx") {
            return Err(Error::operator(&message.op_type, format!(" of `{}`", message.domain)));
        }
        Ok(match message.op_type.as_str() {
            "Add" => Self::Add,
            "Sub" => Self::Sub,
            "Mul" => Self::Mul,
            "Div" => Self::Div,
            "Pow" => Self::Pow,
            "Sqrt" => Self::Sqrt,
            "Relu" => Self::Relu,
            "Identity" => Self::Identity,
            "Conv" => Self::Conv(windows(message)?),
            "MaxPool" => {
                let kernel = sizes(message, "kernel_shape", 1)?
                    .ok_or_else(|| Error::operator("MaxPool", " without a kernel"))?;
                Self::MaxPool(kernel, windows(message)?)
            }
            name @ ("ReduceMean" | "ReduceSum") => Self::Reduce {
                axes: attribute(message, "axes").map(|a| a.ints.clone()).unwrap_or_default(),
                keep: attribute(message, "keepdims").is_none_or(|a| a.i != 0),
                mean: name == "ReduceMean",
            },
            other => return Err(Error::operator(other, "")),
        })
    }
}

fn windows(message: &NodeMessage) -> Result<Windows, Error> {
    let plain = |name: &str, value: i64| attribute(message, name).is_none_or(|a| a.i == value);
    let padding = attribute(message, "auto_pad").is_none_or(|a| a.s == b"NOTSET");
    let is_dilated =
        attribute(message, "dilations").is_some_and(|a| a.ints.iter().any(|i| *i != 1));
    if !plain("group", 1) || !plain("ceil_mode", 0) || !padding || is_dilated {
        return Err(Error::operator(
            &message.op_type,
            " with groups, dilations, ceil_mode or auto_pad",
        ));
    }
    let strides = sizes(message, "strides", 1)?.unwrap_or([1; 2]);
    Ok(Windows { strides, pads: sizes(message, "pads", 0)?.unwrap_or([0; 4]) })
}

/// Sizes of an attribute, from `least` to 1024.
fn sizes<const N: usize>(
    message: &NodeMessage,
    name: &str,
    least: i64,
) -> Result<Option<[usize; N]>, Error> {
    let Some(attribute) = attribute(message, name) else { return Ok(None) };
    let wrong = || Error::operator(&message.op_type, format!(" with {name} {:?}", attribute.ints));
    let sizes: [i64; N] = attribute.ints.clone().try_into().map_err(|_| wrong())?;
    if sizes.iter().any(|n| !(least..=1024).contains(n)) {
        return Err(wrong());
    }
    Ok(Some(sizes.map(|n| n as usize)))
}

fn attribute<'a>(message: &'a NodeMessage, name: &str) -> Option<&'a AttributeMessage> {
    message.attribute.iter().find(|a| a.name == name)
}

fn missing(name: &str) -> Error {
    Error::Network(format!("`{name}` is read before it is computed"))
}
