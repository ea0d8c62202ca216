
impl Fields for crate::v1::RollOutRequest {
    const NAME: &'static str = "RollOutRequest";
    const FIELDS: &'static [&'static str] = &["twin", "trajectories", "poses", "initial", "frames", "costs", "returns", "fidelity"];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.twin = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { only_one(&mut self.actions, message(map)?.map(crate::v1::roll_out_request::Actions::Trajectories))?; }
2 => { only_one(&mut self.actions, message(map)?.map(crate::v1::roll_out_request::Actions::Poses))?; }
3 => { self.initial = message(map)?; }
4 => { self.frames = map.next_value::<Option<_>>()?.unwrap_or_default(); }
5 => { self.costs = messages(map)?; }
6 => { self.returns = message(map)?; }
7 => { self.fidelity = word::<crate::v1::Fidelity, A>(map)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("twin", &self.twin)?;
if let Some(crate::v1::roll_out_request::Actions::Trajectories(value)) = &self.actions { write_message(map, "trajectories", Some(value), tensors)?; }
if let Some(crate::v1::roll_out_request::Actions::Poses(value)) = &self.actions { write_message(map, "poses", Some(value), tensors)?; }
write_message(map, "initial", self.initial.as_ref(), tensors)?;
map.serialize_entry("frames", &self.frames)?;
write_messages(map, "costs", &self.costs, tensors)?;
write_message(map, "returns", self.returns.as_ref(), tensors)?;
write_word::<crate::v1::Fidelity, M>(map, "fidelity", self.fidelity)?;

        Ok(())
    }
}

impl Fields for crate::v1::ControlTrajectories {
    const NAME: &'static str = "ControlTrajectories";
    const FIELDS: &'static [&'static str] = &["positions", "interpolation"];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.positions = tensor(map, Dtype::Float32)?; }
1 => { self.interpolation = word::<crate::v1::Interpolation, A>(map)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_tensor(map, "positions", self.positions.as_ref(), tensors)?;
write_word::<crate::v1::Interpolation, M>(map, "interpolation", self.interpolation)?;

        Ok(())
    }
}

impl Fields for crate::v1::GripperPoses {
    const NAME: &'static str = "GripperPoses";
    const FIELDS: &'static [&'static str] = &["poses", "gripper_of_control", "interpolation"];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.poses = tensor(map, Dtype::Float32)?; }
1 => { self.gripper_of_control = tensor(map, Dtype::Uint32)?; }
2 => { self.interpolation = word::<crate::v1::Interpolation, A>(map)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_tensor(map, "poses", self.poses.as_ref(), tensors)?;
write_tensor(map, "gripper_of_control", self.gripper_of_control.as_ref(), tensors)?;
write_word::<crate::v1::Interpolation, M>(map, "interpolation", self.interpolation)?;

        Ok(())
    }
}

impl Fields for crate::v1::InitialState {
    const NAME: &'static str = "InitialState";
    const FIELDS: &'static [&'static str] = &["rest", "capture_frame", "given"];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { only_one(&mut self.state, message(map)?.map(crate::v1::initial_state::State::Rest))?; }
1 => { only_one(&mut self.state, message(map)?.map(crate::v1::initial_state::State::CaptureFrame))?; }
2 => { only_one(&mut self.state, message(map)?.map(crate::v1::initial_state::State::Given))?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        if let Some(crate::v1::initial_state::State::Rest(value)) = &self.state { write_message(map, "rest", Some(value), tensors)?; }
if let Some(crate::v1::initial_state::State::CaptureFrame(value)) = &self.state { write_message(map, "capture_frame", Some(value), tensors)?; }
if let Some(crate::v1::initial_state::State::Given(value)) = &self.state { write_message(map, "given", Some(value), tensors)?; }

        Ok(())
    }
}

impl Fields for crate::v1::initial_state::Rest {
    const NAME: &'static str = "Rest";
    const FIELDS: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            
            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        
        Ok(())
    }
}

impl Fields for crate::v1::initial_state::CaptureFrame {
    const NAME: &'static str = "CaptureFrame";
    const FIELDS: &'static [&'static str] = &["capture", "sequence", "frame"];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.capture = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.sequence = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.frame = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("capture", &self.capture)?;
map.serialize_entry("sequence", &self.sequence)?;
map.serialize_entry("frame", &self.frame)?;

        Ok(())
    }
}

impl Fields for crate::v1::initial_state::GivenState {
    const NAME: &'static str = "GivenState";
    const FIELDS: &'static [&'static str] = &["positions", "velocities", "twists"];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.positions = tensor(map, Dtype::Float32)?; }
1 => { self.velocities = tensor(map, Dtype::Float32)?; }
2 => { self.twists = tensor(map, Dtype::Float32)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_tensor(map, "positions", self.positions.as_ref(), tensors)?;
write_tensor(map, "velocities", self.velocities.as_ref(), tensors)?;
write_tensor(map, "twists", self.twists.as_ref(), tensors)?;

        Ok(())
    }
}

impl Fields for crate::v1::Cost {
    const NAME: &'static str = "Cost";
    const FIELDS: &'static [&'static str] = &["name", "weight", "when", "target_cloud", "keypoints", "smoothness"];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.weight = map.next_value()?; }
2 => { self.when = word::<crate::v1::cost::When, A>(map)?; }
3 => { only_one(&mut self.kind, message(map)?.map(crate::v1::cost::Kind::TargetCloud))?; }
4 => { only_one(&mut self.kind, message(map)?.map(crate::v1::cost::Kind::Keypoints))?; }
5 => { only_one(&mut self.kind, message(map)?.map(crate::v1::cost::Kind::Smoothness))?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("name", &self.name)?;
if let Some(value) = &self.weight { map.serialize_entry("weight", value)?; }
write_word::<crate::v1::cost::When, M>(map, "when", self.when)?;
if let Some(crate::v1::cost::Kind::TargetCloud(value)) = &self.kind { write_message(map, "target_cloud", Some(value), tensors)?; }
if let Some(crate::v1::cost::Kind::Keypoints(value)) = &self.kind { write_message(map, "keypoints", Some(value), tensors)?; }
if let Some(crate::v1::cost::Kind::Smoothness(value)) = &self.kind { write_message(map, "smoothness", Some(value), tensors)?; }

        Ok(())
    }
}

impl Fields for crate::v1::cost::TargetCloud {
    const NAME: &'static str = "TargetCloud";
    const FIELDS: &'static [&'static str] = &["points"];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.points = tensor(map, Dtype::Float32)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_tensor(map, "points", self.points.as_ref(), tensors)?;

        Ok(())
    }
}

impl Fields for crate::v1::cost::Keypoints {
    const NAME: &'static str = "Keypoints";
    const FIELDS: &'static [&'static str] = &["nodes", "targets", "squared"];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.nodes = tensor(map, Dtype::Uint32)?; }
1 => { self.targets = tensor(map, Dtype::Float32)?; }
2 => { self.squared = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_tensor(map, "nodes", self.nodes.as_ref(), tensors)?;
write_tensor(map, "targets", self.targets.as_ref(), tensors)?;
map.serialize_entry("squared", &self.squared)?;

        Ok(())
    }
}

impl Fields for crate::v1::cost::Smoothness {
    const NAME: &'static str = "Smoothness";
    const FIELDS: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            
            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        
        Ok(())
    }
}

impl Words for crate::v1::cost::When {
    const KNOWN: &'static [&'static str] = &["LAST_FRAME", "EVERY_FRAME"];
    fn number(word: &str) -> Option<i32> {
        Self::from_str_name(word).map(Into::into)
    }
    fn word(number: i32) -> Option<&'static str> {
        Self::try_from(number).ok().map(|value| value.as_str_name())
    }
}

impl Fields for crate::v1::Returns {
    const NAME: &'static str = "Returns";
    const FIELDS: &'static [&'static str] = &["every_frames", "nodes", "encoding", "best", "final_state", "diagnostics", "control_gradients"];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.every_frames = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.nodes = tensor(map, Dtype::Uint32)?; }
2 => { self.encoding = word::<crate::v1::returns::Encoding, A>(map)?; }
3 => { self.best = map.next_value::<Option<_>>()?.unwrap_or_default(); }
4 => { self.final_state = map.next_value::<Option<_>>()?.unwrap_or_default(); }
5 => { self.diagnostics = map.next_value::<Option<_>>()?.unwrap_or_default(); }
6 => { self.control_gradients = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("every_frames", &self.every_frames)?;
write_tensor(map, "nodes", self.nodes.as_ref(), tensors)?;
write_word::<crate::v1::returns::Encoding, M>(map, "encoding", self.encoding)?;
map.serialize_entry("best", &self.best)?;
map.serialize_entry("final_state", &self.final_state)?;
map.serialize_entry("diagnostics", &self.diagnostics)?;
map.serialize_entry("control_gradients", &self.control_gradients)?;

        Ok(())
    }
}

impl Words for crate::v1::returns::Encoding {
    const KNOWN: &'static [&'static str] = &["FLOAT32", "INT16"];
    fn number(word: &str) -> Option<i32> {
        Self::from_str_name(word).map(Into::into)
    }
    fn word(number: i32) -> Option<&'static str> {
        Self::try_from(number).ok().map(|value| value.as_str_name())
    }
}

impl Fields for crate::v1::RollOutResponse {
    const NAME: &'static str = "RollOutResponse";
    const FIELDS: &'static [&'static str] = &["first_instance", "costs", "cost_names", "cost_terms", "instances", "frames", "positions", "final_positions", "final_velocities", "control_gradients", "diagnostics", "diverged", "timing", "worker", "fidelity", "substeps", "deviation", "final_twists"];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.first_instance = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.costs = tensor(map, Dtype::Float32)?; }
2 => { self.cost_names = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.cost_terms = tensor(map, Dtype::Float32)?; }
4 => { self.instances = tensor(map, Dtype::Uint32)?; }
5 => { self.frames = tensor(map, Dtype::Float32)?; }
6 => { self.positions = tensor(map, Dtype::Float32)?; }
7 => { self.final_positions = tensor(map, Dtype::Float32)?; }
8 => { self.final_velocities = tensor(map, Dtype::Float32)?; }
9 => { self.control_gradients = tensor(map, Dtype::Float32)?; }
10 => { self.diagnostics = messages(map)?; }
11 => { self.diverged = messages(map)?; }
12 => { self.timing = message(map)?; }
13 => { self.worker = map.next_value::<Option<_>>()?.unwrap_or_default(); }
14 => { self.fidelity = word::<crate::v1::Fidelity, A>(map)?; }
15 => { self.substeps = map.next_value::<Option<_>>()?.unwrap_or_default(); }
16 => { self.deviation = message(map)?; }
17 => { self.final_twists = tensor(map, Dtype::Float32)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("first_instance", &self.first_instance)?;
write_tensor(map, "costs", self.costs.as_ref(), tensors)?;
map.serialize_entry("cost_names", &self.cost_names)?;
write_tensor(map, "cost_terms", self.cost_terms.as_ref(), tensors)?;
write_tensor(map, "instances", self.instances.as_ref(), tensors)?;
write_tensor(map, "frames", self.frames.as_ref(), tensors)?;
write_tensor(map, "positions", self.positions.as_ref(), tensors)?;
write_tensor(map, "final_positions", self.final_positions.as_ref(), tensors)?;
write_tensor(map, "final_velocities", self.final_velocities.as_ref(), tensors)?;
write_tensor(map, "control_gradients", self.control_gradients.as_ref(), tensors)?;
write_messages(map, "diagnostics", &self.diagnostics, tensors)?;
write_messages(map, "diverged", &self.diverged, tensors)?;
write_message(map, "timing", self.timing.as_ref(), tensors)?;
map.serialize_entry("worker", &self.worker)?;
write_word::<crate::v1::Fidelity, M>(map, "fidelity", self.fidelity)?;
map.serialize_entry("substeps", &self.substeps)?;
write_message(map, "deviation", self.deviation.as_ref(), tensors)?;
write_tensor(map, "final_twists", self.final_twists.as_ref(), tensors)?;

        Ok(())
    }
}

impl Fields for crate::v1::roll_out_response::Diagnostics {
    const NAME: &'static str = "Diagnostics";
    const FIELDS: &'static [&'static str] = &["max_strain", "max_speed_m_s", "kinetic_energy", "elastic_energy", "ground_contacts"];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.max_strain = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.max_speed_m_s = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.kinetic_energy = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.elastic_energy = map.next_value::<Option<_>>()?.unwrap_or_default(); }
4 => { self.ground_contacts = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("max_strain", &self.max_strain)?;
map.serialize_entry("max_speed_m_s", &self.max_speed_m_s)?;
map.serialize_entry("kinetic_energy", &self.kinetic_energy)?;
map.serialize_entry("elastic_energy", &self.elastic_energy)?;
map.serialize_entry("ground_contacts", &self.ground_contacts)?;

        Ok(())
    }
}

impl Fields for crate::v1::roll_out_response::Divergence {
    const NAME: &'static str = "Divergence";
    const FIELDS: &'static [&'static str] = &["instance", "frame", "node"];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.instance = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.frame = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.node = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("instance", &self.instance)?;
map.serialize_entry("frame", &self.frame)?;
map.serialize_entry("node", &self.node)?;

        Ok(())
    }
}

impl Fields for crate::v1::roll_out_response::Timing {
    const NAME: &'static str = "Timing";
    const FIELDS: &'static [&'static str] = &["queue_s", "compute_s"];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.queue_s = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.compute_s = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("queue_s", &self.queue_s)?;
map.serialize_entry("compute_s", &self.compute_s)?;

        Ok(())
    }
}

impl Fields for crate::v1::roll_out_response::Deviation {
    const NAME: &'static str = "Deviation";
    const FIELDS: &'static [&'static str] = &["mean_m", "max_m", "mean_travel_m", "frames"];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.mean_m = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.max_m = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.mean_travel_m = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.frames = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("mean_m", &self.mean_m)?;
map.serialize_entry("max_m", &self.max_m)?;
map.serialize_entry("mean_travel_m", &self.mean_travel_m)?;
map.serialize_entry("frames", &self.frames)?;

        Ok(())
    }
}

impl Words for crate::v1::Fidelity {
    const KNOWN: &'static [&'static str] = &["EXACT", "FAST"];
    fn number(word: &str) -> Option<i32> {
        Self::from_str_name(word).map(Into::into)
    }
    fn word(number: i32) -> Option<&'static str> {
        Self::try_from(number).ok().map(|value| value.as_str_name())
    }
}

impl Words for crate::v1::Interpolation {
    const KNOWN: &'static [&'static str] = &["LINEAR", "CUBIC"];
    fn number(word: &str) -> Option<i32> {
        Self::from_str_name(word).map(Into::into)
    }
    fn word(number: i32) -> Option<&'static str> {
        Self::try_from(number).ok().map(|value| value.as_str_name())
    }
}
