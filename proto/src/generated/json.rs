
impl Fields for crate::v1::Fault {
    const NAME: &'static str = "Fault";
    const FIELDS: &'static [&'static str] = &["category", "reason", "message"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.category = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.reason = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.message = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("category", &self.category)?;
map.serialize_entry("reason", &self.reason)?;
map.serialize_entry("message", &self.message)?;

        Ok(())
    }
}
written!(crate::v1::Fault);

impl Fields for crate::v1::World {
    const NAME: &'static str = "World";
    const FIELDS: &'static [&'static str] = &["gravity", "ground", "no_ground", "ground_friction", "ground_restitution", "colliders"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.gravity = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { only_one(&mut self.ground_choice, message(map)?.map(crate::v1::world::GroundChoice::Ground))?; }
2 => { only_one(&mut self.ground_choice, map.next_value::<Option<_>>()?.map(crate::v1::world::GroundChoice::NoGround))?; }
3 => { self.ground_friction = map.next_value()?; }
4 => { self.ground_restitution = map.next_value()?; }
5 => { self.colliders = messages(map)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("gravity", &self.gravity)?;
if let Some(crate::v1::world::GroundChoice::Ground(value)) = &self.ground_choice { write_message(map, "ground", Some(value), tensors)?; }
if let Some(crate::v1::world::GroundChoice::NoGround(value)) = &self.ground_choice { map.serialize_entry("no_ground", value)?; }
if let Some(value) = &self.ground_friction { map.serialize_entry("ground_friction", value)?; }
if let Some(value) = &self.ground_restitution { map.serialize_entry("ground_restitution", value)?; }
write_messages(map, "colliders", &self.colliders, tensors)?;

        Ok(())
    }
}
written!(crate::v1::World);

impl Fields for crate::v1::Plane {
    const NAME: &'static str = "Plane";
    const FIELDS: &'static [&'static str] = &["normal", "offset_m"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.normal = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.offset_m = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("normal", &self.normal)?;
map.serialize_entry("offset_m", &self.offset_m)?;

        Ok(())
    }
}
written!(crate::v1::Plane);

impl Fields for crate::v1::Collider {
    const NAME: &'static str = "Collider";
    const FIELDS: &'static [&'static str] = &["name", "sphere", "capsule", "cuboid", "convex_mesh", "friction", "restitution", "margin_m", "fixed", "gripper", "path", "pose"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { only_one(&mut self.shape, message(map)?.map(crate::v1::collider::Shape::Sphere))?; }
2 => { only_one(&mut self.shape, message(map)?.map(crate::v1::collider::Shape::Capsule))?; }
3 => { only_one(&mut self.shape, message(map)?.map(crate::v1::collider::Shape::Cuboid))?; }
4 => { only_one(&mut self.shape, message(map)?.map(crate::v1::collider::Shape::ConvexMesh))?; }
5 => { self.friction = map.next_value()?; }
6 => { self.restitution = map.next_value()?; }
7 => { self.margin_m = map.next_value::<Option<_>>()?.unwrap_or_default(); }
8 => { only_one(&mut self.carrier, message(map)?.map(crate::v1::collider::Carrier::Fixed))?; }
9 => { only_one(&mut self.carrier, map.next_value::<Option<_>>()?.map(crate::v1::collider::Carrier::Gripper))?; }
10 => { only_one(&mut self.carrier, tensor(map, Dtype::Float32)?.map(crate::v1::collider::Carrier::Path))?; }
11 => { self.pose = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("name", &self.name)?;
if let Some(crate::v1::collider::Shape::Sphere(value)) = &self.shape { write_message(map, "sphere", Some(value), tensors)?; }
if let Some(crate::v1::collider::Shape::Capsule(value)) = &self.shape { write_message(map, "capsule", Some(value), tensors)?; }
if let Some(crate::v1::collider::Shape::Cuboid(value)) = &self.shape { write_message(map, "cuboid", Some(value), tensors)?; }
if let Some(crate::v1::collider::Shape::ConvexMesh(value)) = &self.shape { write_message(map, "convex_mesh", Some(value), tensors)?; }
if let Some(value) = &self.friction { map.serialize_entry("friction", value)?; }
if let Some(value) = &self.restitution { map.serialize_entry("restitution", value)?; }
map.serialize_entry("margin_m", &self.margin_m)?;
if let Some(crate::v1::collider::Carrier::Fixed(value)) = &self.carrier { write_message(map, "fixed", Some(value), tensors)?; }
if let Some(crate::v1::collider::Carrier::Gripper(value)) = &self.carrier { map.serialize_entry("gripper", value)?; }
if let Some(crate::v1::collider::Carrier::Path(value)) = &self.carrier { write_tensor(map, "path", Some(value), tensors)?; }
map.serialize_entry("pose", &self.pose)?;

        Ok(())
    }
}
written!(crate::v1::Collider);

impl Fields for crate::v1::collider::Fixed {
    const NAME: &'static str = "Fixed";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::collider::Fixed);

impl Fields for crate::v1::Sphere {
    const NAME: &'static str = "Sphere";
    const FIELDS: &'static [&'static str] = &["center", "radius_m"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.center = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.radius_m = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("center", &self.center)?;
map.serialize_entry("radius_m", &self.radius_m)?;

        Ok(())
    }
}
written!(crate::v1::Sphere);

impl Fields for crate::v1::Capsule {
    const NAME: &'static str = "Capsule";
    const FIELDS: &'static [&'static str] = &["from", "to", "radius_m"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.from = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.to = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.radius_m = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("from", &self.from)?;
map.serialize_entry("to", &self.to)?;
map.serialize_entry("radius_m", &self.radius_m)?;

        Ok(())
    }
}
written!(crate::v1::Capsule);

impl Fields for crate::v1::Cuboid {
    const NAME: &'static str = "Cuboid";
    const FIELDS: &'static [&'static str] = &["low", "high"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.low = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.high = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("low", &self.low)?;
map.serialize_entry("high", &self.high)?;

        Ok(())
    }
}
written!(crate::v1::Cuboid);

impl Fields for crate::v1::ConvexMesh {
    const NAME: &'static str = "ConvexMesh";
    const FIELDS: &'static [&'static str] = &["points"];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::ConvexMesh);

impl Fields for crate::v1::Grasp {
    const NAME: &'static str = "Grasp";
    const FIELDS: &'static [&'static str] = &["gripper", "sphere", "cuboid", "nodes", "hand", "attachment", "stiffness", "damping", "closed", "max_force_n"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.gripper = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { only_one(&mut self.region, message(map)?.map(crate::v1::grasp::Region::Sphere))?; }
2 => { only_one(&mut self.region, message(map)?.map(crate::v1::grasp::Region::Cuboid))?; }
3 => { only_one(&mut self.region, tensor(map, Dtype::Uint32)?.map(crate::v1::grasp::Region::Nodes))?; }
4 => { only_one(&mut self.region, message(map)?.map(crate::v1::grasp::Region::Hand))?; }
5 => { self.attachment = word::<crate::v1::grasp::Attachment, A>(map)?; }
6 => { self.stiffness = map.next_value::<Option<_>>()?.unwrap_or_default(); }
7 => { self.damping = map.next_value::<Option<_>>()?.unwrap_or_default(); }
8 => { self.closed = tensor(map, Dtype::Uint32)?; }
9 => { self.max_force_n = map.next_value()?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("gripper", &self.gripper)?;
if let Some(crate::v1::grasp::Region::Sphere(value)) = &self.region { write_message(map, "sphere", Some(value), tensors)?; }
if let Some(crate::v1::grasp::Region::Cuboid(value)) = &self.region { write_message(map, "cuboid", Some(value), tensors)?; }
if let Some(crate::v1::grasp::Region::Nodes(value)) = &self.region { write_tensor(map, "nodes", Some(value), tensors)?; }
if let Some(crate::v1::grasp::Region::Hand(value)) = &self.region { write_message(map, "hand", Some(value), tensors)?; }
write_word::<crate::v1::grasp::Attachment, M>(map, "attachment", self.attachment)?;
map.serialize_entry("stiffness", &self.stiffness)?;
map.serialize_entry("damping", &self.damping)?;
write_tensor(map, "closed", self.closed.as_ref(), tensors)?;
if let Some(value) = &self.max_force_n { map.serialize_entry("max_force_n", value)?; }

        Ok(())
    }
}
written!(crate::v1::Grasp);

impl Fields for crate::v1::grasp::CaptureHand {
    const NAME: &'static str = "CaptureHand";
    const FIELDS: &'static [&'static str] = &["hand"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.hand = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("hand", &self.hand)?;

        Ok(())
    }
}
written!(crate::v1::grasp::CaptureHand);

impl Words for crate::v1::grasp::Attachment {
    const KNOWN: &'static [&'static str] = &["PIN", "SPRINGS"];
    fn number(word: &str) -> Option<i32> {
        Self::from_str_name(word).map(Into::into)
    }
    fn word(number: i32) -> Option<&'static str> {
        Self::try_from(number).ok().map(|value| value.as_str_name())
    }
}
word_written!(crate::v1::grasp::Attachment);

impl Fields for crate::v1::Grasping {
    const NAME: &'static str = "Grasping";
    const FIELDS: &'static [&'static str] = &["phases", "holders", "places"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.phases = tensor(map, Dtype::Uint32)?; }
1 => { self.holders = tensor(map, Dtype::Uint32)?; }
2 => { self.places = tensor(map, Dtype::Float32)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_tensor(map, "phases", self.phases.as_ref(), tensors)?;
write_tensor(map, "holders", self.holders.as_ref(), tensors)?;
write_tensor(map, "places", self.places.as_ref(), tensors)?;

        Ok(())
    }
}
written!(crate::v1::Grasping);

impl Fields for crate::v1::Vary {
    const NAME: &'static str = "Vary";
    const FIELDS: &'static [&'static str] = &["stiffness", "damping", "bending", "friction", "mass", "fits", "ground_restitution", "object_restitution"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.stiffness = tensor(map, Dtype::Float32)?; }
1 => { self.damping = tensor(map, Dtype::Float32)?; }
2 => { self.bending = tensor(map, Dtype::Float32)?; }
3 => { self.friction = tensor(map, Dtype::Float32)?; }
4 => { self.mass = tensor(map, Dtype::Float32)?; }
5 => { self.fits = map.next_value::<Option<_>>()?.unwrap_or_default(); }
6 => { self.ground_restitution = tensor(map, Dtype::Float32)?; }
7 => { self.object_restitution = tensor(map, Dtype::Float32)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_tensor(map, "stiffness", self.stiffness.as_ref(), tensors)?;
write_tensor(map, "damping", self.damping.as_ref(), tensors)?;
write_tensor(map, "bending", self.bending.as_ref(), tensors)?;
write_tensor(map, "friction", self.friction.as_ref(), tensors)?;
write_tensor(map, "mass", self.mass.as_ref(), tensors)?;
map.serialize_entry("fits", &self.fits)?;
write_tensor(map, "ground_restitution", self.ground_restitution.as_ref(), tensors)?;
write_tensor(map, "object_restitution", self.object_restitution.as_ref(), tensors)?;

        Ok(())
    }
}
written!(crate::v1::Vary);

impl Fields for crate::v1::Job {
    const NAME: &'static str = "Job";
    const FIELDS: &'static [&'static str] = &["state", "settings", "progress", "fault", "attempt_faults", "attempts", "worker", "cancel_requested", "create_time", "start_time", "end_time", "revision", "run_s"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.state = word::<crate::v1::job::State, A>(map)?; }
1 => { self.settings_json = document(map)?; }
2 => { self.progress = message(map)?; }
3 => { self.fault = message(map)?; }
4 => { self.attempt_faults = messages(map)?; }
5 => { self.attempts = map.next_value::<Option<_>>()?.unwrap_or_default(); }
6 => { self.worker = map.next_value::<Option<_>>()?.unwrap_or_default(); }
7 => { self.cancel_requested = map.next_value::<Option<_>>()?.unwrap_or_default(); }
8 => { self.create_time = time(map)?; }
9 => { self.start_time = time(map)?; }
10 => { self.end_time = time(map)?; }
11 => { self.revision = map.next_value::<Option<_>>()?.unwrap_or_default(); }
12 => { self.run_s = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_word::<crate::v1::job::State, M>(map, "state", self.state)?;
write_document(map, "settings", &self.settings_json)?;
map.serialize_entry("progress", &self.progress.as_ref().map(|message| Write { message, tensors }))?;
map.serialize_entry("fault", &self.fault.as_ref().map(|message| Write { message, tensors }))?;
write_messages(map, "attempt_faults", &self.attempt_faults, tensors)?;
map.serialize_entry("attempts", &self.attempts)?;
map.serialize_entry("worker", &filled(&self.worker))?;
map.serialize_entry("cancel_requested", &self.cancel_requested)?;
map.serialize_entry("create_time", &Time(self.create_time.unwrap_or_default()))?;
map.serialize_entry("start_time", &self.start_time.map(Time))?;
map.serialize_entry("end_time", &self.end_time.map(Time))?;
map.serialize_entry("revision", &self.revision)?;
map.serialize_entry("run_s", &self.run_s)?;

        Ok(())
    }
}
written!(crate::v1::Job);

impl Words for crate::v1::job::State {
    const KNOWN: &'static [&'static str] = &["QUEUED", "RUNNING", "SUCCEEDED", "FAILED", "CANCELLED"];
    fn number(word: &str) -> Option<i32> {
        Self::from_str_name(word).map(Into::into)
    }
    fn word(number: i32) -> Option<&'static str> {
        Self::try_from(number).ok().map(|value| value.as_str_name())
    }
}
word_written!(crate::v1::job::State);

impl Fields for crate::v1::Progress {
    const NAME: &'static str = "Progress";
    const FIELDS: &'static [&'static str] = &["stage", "variant", "iteration", "iterations", "fraction", "loss", "best_loss", "eta_s", "note", "models", "error_m"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.stage = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.variant = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.iteration = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.iterations = map.next_value::<Option<_>>()?.unwrap_or_default(); }
4 => { self.fraction = map.next_value::<Option<_>>()?.unwrap_or_default(); }
5 => { self.loss = map.next_value()?; }
6 => { self.best_loss = map.next_value()?; }
7 => { self.eta_s = map.next_value()?; }
8 => { self.note = map.next_value::<Option<_>>()?.unwrap_or_default(); }
9 => { self.models = messages(map)?; }
10 => { self.error_m = map.next_value()?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("stage", &self.stage)?;
map.serialize_entry("variant", &self.variant)?;
map.serialize_entry("iteration", &self.iteration)?;
map.serialize_entry("iterations", &self.iterations)?;
map.serialize_entry("fraction", &self.fraction)?;
map.serialize_entry("loss", &self.loss)?;
map.serialize_entry("best_loss", &self.best_loss)?;
map.serialize_entry("eta_s", &self.eta_s)?;
map.serialize_entry("note", &filled(&self.note))?;
write_messages(map, "models", &self.models, tensors)?;
map.serialize_entry("error_m", &self.error_m)?;

        Ok(())
    }
}
written!(crate::v1::Progress);

impl Fields for crate::v1::ModelLoss {
    const NAME: &'static str = "ModelLoss";
    const FIELDS: &'static [&'static str] = &["stage", "variant", "iteration", "loss", "best_loss", "error_m"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.stage = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.variant = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.iteration = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.loss = map.next_value()?; }
4 => { self.best_loss = map.next_value()?; }
5 => { self.error_m = map.next_value()?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("stage", &self.stage)?;
map.serialize_entry("variant", &self.variant)?;
map.serialize_entry("iteration", &self.iteration)?;
map.serialize_entry("loss", &self.loss)?;
map.serialize_entry("best_loss", &self.best_loss)?;
map.serialize_entry("error_m", &self.error_m)?;

        Ok(())
    }
}
written!(crate::v1::ModelLoss);

impl Fields for crate::v1::WorkerRequirements {
    const NAME: &'static str = "WorkerRequirements";
    const FIELDS: &'static [&'static str] = &["backend", "memory_bytes", "labels"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.backend = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.memory_bytes = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.labels = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("backend", &self.backend)?;
map.serialize_entry("memory_bytes", &self.memory_bytes)?;
map.serialize_entry("labels", &self.labels)?;

        Ok(())
    }
}
written!(crate::v1::WorkerRequirements);

impl Fields for crate::v1::Capture {
    const NAME: &'static str = "Capture";
    const FIELDS: &'static [&'static str] = &["name", "display_name", "create_time", "size_bytes", "digest", "ingest", "verdict", "note", "tags", "owner", "ingest_requirements", "recorded_by", "supplements", "masks"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.display_name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.create_time = time(map)?; }
3 => { self.size_bytes = map.next_value::<Option<_>>()?.unwrap_or_default(); }
4 => { self.digest = map.next_value::<Option<_>>()?.unwrap_or_default(); }
5 => { self.ingest = message(map)?; }
6 => { self.verdict = map.next_value::<Option<_>>()?.unwrap_or_default(); }
7 => { self.note = map.next_value::<Option<_>>()?.unwrap_or_default(); }
8 => { self.tags = map.next_value::<Option<_>>()?.unwrap_or_default(); }
9 => { self.owner = map.next_value::<Option<_>>()?.unwrap_or_default(); }
10 => { self.ingest_requirements = message(map)?; }
11 => { self.recorded_by = map.next_value::<Option<_>>()?.unwrap_or_default(); }
12 => { self.supplements = messages(map)?; }
13 => { self.masks = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("name", &self.name)?;
map.serialize_entry("display_name", &self.display_name)?;
map.serialize_entry("create_time", &Time(self.create_time.unwrap_or_default()))?;
map.serialize_entry("size_bytes", &self.size_bytes)?;
map.serialize_entry("digest", &self.digest)?;
write_message(map, "ingest", Some(self.ingest.as_ref().unwrap_or(&Default::default())), tensors)?;
map.serialize_entry("verdict", &filled(&self.verdict))?;
map.serialize_entry("note", &self.note)?;
map.serialize_entry("tags", &self.tags)?;
map.serialize_entry("owner", &self.owner)?;
write_message(map, "ingest_requirements", Some(self.ingest_requirements.as_ref().unwrap_or(&Default::default())), tensors)?;
map.serialize_entry("recorded_by", &self.recorded_by)?;
write_messages(map, "supplements", &self.supplements, tensors)?;
map.serialize_entry("masks", &self.masks)?;

        Ok(())
    }
}
written!(crate::v1::Capture);

impl Fields for crate::v1::Supplement {
    const NAME: &'static str = "Supplement";
    const FIELDS: &'static [&'static str] = &["kind", "size_bytes", "digest", "create_time"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.kind = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.size_bytes = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.digest = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.create_time = time(map)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("kind", &self.kind)?;
map.serialize_entry("size_bytes", &self.size_bytes)?;
map.serialize_entry("digest", &self.digest)?;
map.serialize_entry("create_time", &Time(self.create_time.unwrap_or_default()))?;

        Ok(())
    }
}
written!(crate::v1::Supplement);

impl Fields for crate::v1::CaptureMetadata {
    const NAME: &'static str = "CaptureMetadata";
    const FIELDS: &'static [&'static str] = &["display_name", "digest", "ingest", "ingest_requirements", "recorded_by"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.display_name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.digest = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.ingest_json = document(map)?; }
3 => { self.ingest_requirements = message(map)?; }
4 => { self.recorded_by = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("display_name", &self.display_name)?;
map.serialize_entry("digest", &self.digest)?;
write_document(map, "ingest", &self.ingest_json)?;
write_message(map, "ingest_requirements", self.ingest_requirements.as_ref(), tensors)?;
map.serialize_entry("recorded_by", &self.recorded_by)?;

        Ok(())
    }
}
written!(crate::v1::CaptureMetadata);

impl Fields for crate::v1::GetCaptureRequest {
    const NAME: &'static str = "GetCaptureRequest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::GetCaptureRequest);

impl Fields for crate::v1::ListCapturesRequest {
    const NAME: &'static str = "ListCapturesRequest";
    const FIELDS: &'static [&'static str] = &["page_size", "page_token", "search", "tag", "order_by", "owner", "recorded_by"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.page_size = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.page_token = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.search = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.tag = map.next_value::<Option<_>>()?.unwrap_or_default(); }
4 => { self.order_by = map.next_value::<Option<_>>()?.unwrap_or_default(); }
5 => { self.owner = map.next_value::<Option<_>>()?.unwrap_or_default(); }
6 => { self.recorded_by = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("page_size", &self.page_size)?;
map.serialize_entry("page_token", &self.page_token)?;
map.serialize_entry("search", &self.search)?;
map.serialize_entry("tag", &self.tag)?;
map.serialize_entry("order_by", &self.order_by)?;
map.serialize_entry("owner", &self.owner)?;
map.serialize_entry("recorded_by", &self.recorded_by)?;

        Ok(())
    }
}
written!(crate::v1::ListCapturesRequest);

impl Fields for crate::v1::ListCapturesResponse {
    const NAME: &'static str = "ListCapturesResponse";
    const FIELDS: &'static [&'static str] = &["captures", "next_page_token", "total_size"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.captures = messages(map)?; }
1 => { self.next_page_token = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.total_size = map.next_value()?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_messages(map, "captures", &self.captures, tensors)?;
map.serialize_entry("next_page_token", &self.next_page_token)?;
if let Some(value) = &self.total_size { map.serialize_entry("total_size", value)?; }

        Ok(())
    }
}
written!(crate::v1::ListCapturesResponse);

impl Fields for crate::v1::UpdateCaptureRequest {
    const NAME: &'static str = "UpdateCaptureRequest";
    const FIELDS: &'static [&'static str] = &["display_name", "note", "tags", "recorded_by", "add_tags", "remove_tags"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { if let Some(value) = map.next_value::<Option<_>>()? { self.capture.get_or_insert_default().display_name = value; self.update_mask.get_or_insert_default().paths.push("display_name".to_owned()); } }
1 => { if let Some(value) = map.next_value::<Option<_>>()? { self.capture.get_or_insert_default().note = value; self.update_mask.get_or_insert_default().paths.push("note".to_owned()); } }
2 => { if let Some(value) = map.next_value::<Option<_>>()? { self.capture.get_or_insert_default().tags = value; self.update_mask.get_or_insert_default().paths.push("tags".to_owned()); } }
3 => { if let Some(value) = map.next_value::<Option<_>>()? { self.capture.get_or_insert_default().recorded_by = value; self.update_mask.get_or_insert_default().paths.push("recorded_by".to_owned()); } }
4 => { self.add_tags = map.next_value::<Option<_>>()?.unwrap_or_default(); }
5 => { self.remove_tags = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        



map.serialize_entry("add_tags", &self.add_tags)?;
map.serialize_entry("remove_tags", &self.remove_tags)?;

        Ok(())
    }
}
written!(crate::v1::UpdateCaptureRequest);

impl Fields for crate::v1::DeleteCaptureRequest {
    const NAME: &'static str = "DeleteCaptureRequest";
    const FIELDS: &'static [&'static str] = &["purge"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.purge = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("purge", &self.purge)?;

        Ok(())
    }
}
written!(crate::v1::DeleteCaptureRequest);

impl Fields for crate::v1::DeleteCaptureResponse {
    const NAME: &'static str = "DeleteCaptureResponse";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::DeleteCaptureResponse);

impl Fields for crate::v1::IngestCaptureRequest {
    const NAME: &'static str = "IngestCaptureRequest";
    const FIELDS: &'static [&'static str] = &["settings", "requirements"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.settings_json = document(map)?; }
1 => { self.requirements = message(map)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_document(map, "settings", &self.settings_json)?;
write_message(map, "requirements", self.requirements.as_ref(), tensors)?;

        Ok(())
    }
}
written!(crate::v1::IngestCaptureRequest);

impl Fields for crate::v1::CancelIngestRequest {
    const NAME: &'static str = "CancelIngestRequest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::CancelIngestRequest);

impl Fields for crate::v1::WatchIngestRequest {
    const NAME: &'static str = "WatchIngestRequest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::WatchIngestRequest);

impl Fields for crate::v1::Fit {
    const NAME: &'static str = "Fit";
    const FIELDS: &'static [&'static str] = &["name", "capture", "twin", "priority", "job", "display_name", "note", "tags", "error_m", "owner", "requirements", "measure"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.capture = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.twin = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.priority = map.next_value::<Option<_>>()?.unwrap_or_default(); }
4 => { self.job = message(map)?; }
5 => { self.display_name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
6 => { self.note = map.next_value::<Option<_>>()?.unwrap_or_default(); }
7 => { self.tags = map.next_value::<Option<_>>()?.unwrap_or_default(); }
8 => { self.error_m = map.next_value()?; }
9 => { self.owner = map.next_value::<Option<_>>()?.unwrap_or_default(); }
10 => { self.requirements = message(map)?; }
11 => { self.measure = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("name", &self.name)?;
map.serialize_entry("capture", &self.capture)?;
map.serialize_entry("twin", &filled(&self.twin))?;
map.serialize_entry("priority", &self.priority)?;
write_message(map, "job", Some(self.job.as_ref().unwrap_or(&Default::default())), tensors)?;
map.serialize_entry("display_name", &self.display_name)?;
map.serialize_entry("note", &self.note)?;
map.serialize_entry("tags", &self.tags)?;
map.serialize_entry("error_m", &self.error_m)?;
map.serialize_entry("owner", &self.owner)?;
write_message(map, "requirements", Some(self.requirements.as_ref().unwrap_or(&Default::default())), tensors)?;
map.serialize_entry("measure", &filled(&self.measure))?;

        Ok(())
    }
}
written!(crate::v1::Fit);

impl Fields for crate::v1::CreateFitRequest {
    const NAME: &'static str = "CreateFitRequest";
    const FIELDS: &'static [&'static str] = &["capture", "settings", "priority", "display_name", "requirements"];
    const REQUIRED: &'static [&'static str] = &["capture"];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.capture = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.settings_json = document(map)?; }
2 => { self.priority = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.display_name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
4 => { self.requirements = message(map)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("capture", &self.capture)?;
write_document(map, "settings", &self.settings_json)?;
map.serialize_entry("priority", &self.priority)?;
map.serialize_entry("display_name", &self.display_name)?;
write_message(map, "requirements", self.requirements.as_ref(), tensors)?;

        Ok(())
    }
}
written!(crate::v1::CreateFitRequest);

impl Fields for crate::v1::GetFitRequest {
    const NAME: &'static str = "GetFitRequest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::GetFitRequest);

impl Fields for crate::v1::ListFitsRequest {
    const NAME: &'static str = "ListFitsRequest";
    const FIELDS: &'static [&'static str] = &["page_size", "page_token", "capture", "state", "search", "tag", "order_by", "owner"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.page_size = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.page_token = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.capture = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.state = word::<crate::v1::job::State, A>(map)?; }
4 => { self.search = map.next_value::<Option<_>>()?.unwrap_or_default(); }
5 => { self.tag = map.next_value::<Option<_>>()?.unwrap_or_default(); }
6 => { self.order_by = map.next_value::<Option<_>>()?.unwrap_or_default(); }
7 => { self.owner = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("page_size", &self.page_size)?;
map.serialize_entry("page_token", &self.page_token)?;
map.serialize_entry("capture", &self.capture)?;
write_word::<crate::v1::job::State, M>(map, "state", self.state)?;
map.serialize_entry("search", &self.search)?;
map.serialize_entry("tag", &self.tag)?;
map.serialize_entry("order_by", &self.order_by)?;
map.serialize_entry("owner", &self.owner)?;

        Ok(())
    }
}
written!(crate::v1::ListFitsRequest);

impl Fields for crate::v1::ListFitsResponse {
    const NAME: &'static str = "ListFitsResponse";
    const FIELDS: &'static [&'static str] = &["fits", "next_page_token", "total_size"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.fits = messages(map)?; }
1 => { self.next_page_token = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.total_size = map.next_value()?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_messages(map, "fits", &self.fits, tensors)?;
map.serialize_entry("next_page_token", &self.next_page_token)?;
if let Some(value) = &self.total_size { map.serialize_entry("total_size", value)?; }

        Ok(())
    }
}
written!(crate::v1::ListFitsResponse);

impl Fields for crate::v1::UpdateFitRequest {
    const NAME: &'static str = "UpdateFitRequest";
    const FIELDS: &'static [&'static str] = &["display_name", "note", "tags", "add_tags", "remove_tags"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { if let Some(value) = map.next_value::<Option<_>>()? { self.fit.get_or_insert_default().display_name = value; self.update_mask.get_or_insert_default().paths.push("display_name".to_owned()); } }
1 => { if let Some(value) = map.next_value::<Option<_>>()? { self.fit.get_or_insert_default().note = value; self.update_mask.get_or_insert_default().paths.push("note".to_owned()); } }
2 => { if let Some(value) = map.next_value::<Option<_>>()? { self.fit.get_or_insert_default().tags = value; self.update_mask.get_or_insert_default().paths.push("tags".to_owned()); } }
3 => { self.add_tags = map.next_value::<Option<_>>()?.unwrap_or_default(); }
4 => { self.remove_tags = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        


map.serialize_entry("add_tags", &self.add_tags)?;
map.serialize_entry("remove_tags", &self.remove_tags)?;

        Ok(())
    }
}
written!(crate::v1::UpdateFitRequest);

impl Fields for crate::v1::GetFitLossesRequest {
    const NAME: &'static str = "GetFitLossesRequest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::GetFitLossesRequest);

impl Fields for crate::v1::FitLosses {
    const NAME: &'static str = "FitLosses";
    const FIELDS: &'static [&'static str] = &["curves"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.curves = messages(map)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_messages(map, "curves", &self.curves, tensors)?;

        Ok(())
    }
}
written!(crate::v1::FitLosses);

impl Fields for crate::v1::fit_losses::LossCurve {
    const NAME: &'static str = "LossCurve";
    const FIELDS: &'static [&'static str] = &["stage", "variant", "iterations", "losses", "best_losses", "errors_m"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.stage = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.variant = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.iterations = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.losses = map.next_value::<Option<_>>()?.unwrap_or_default(); }
4 => { self.best_losses = map.next_value::<Option<_>>()?.unwrap_or_default(); }
5 => { self.errors_m = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("stage", &self.stage)?;
map.serialize_entry("variant", &self.variant)?;
map.serialize_entry("iterations", &self.iterations)?;
map.serialize_entry("losses", &self.losses)?;
map.serialize_entry("best_losses", &self.best_losses)?;
map.serialize_entry("errors_m", &self.errors_m)?;

        Ok(())
    }
}
written!(crate::v1::fit_losses::LossCurve);

impl Fields for crate::v1::GetFitPreviewRequest {
    const NAME: &'static str = "GetFitPreviewRequest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::GetFitPreviewRequest);

impl Fields for crate::v1::FitPreview {
    const NAME: &'static str = "FitPreview";
    const FIELDS: &'static [&'static str] = &["stage", "variant", "iteration", "create_time", "sequence", "frames", "positions", "measure", "error_m", "held_back_m", "baseline_m"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.stage = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.variant = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.iteration = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.create_time = time(map)?; }
4 => { self.sequence = map.next_value::<Option<_>>()?.unwrap_or_default(); }
5 => { self.frames = tensor(map, Dtype::Float32)?; }
6 => { self.positions = tensor(map, Dtype::Float32)?; }
7 => { self.measure = map.next_value::<Option<_>>()?.unwrap_or_default(); }
8 => { self.error_m = map.next_value::<Option<_>>()?.unwrap_or_default(); }
9 => { self.held_back_m = map.next_value()?; }
10 => { self.baseline_m = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("stage", &self.stage)?;
map.serialize_entry("variant", &self.variant)?;
map.serialize_entry("iteration", &self.iteration)?;
map.serialize_entry("create_time", &Time(self.create_time.unwrap_or_default()))?;
map.serialize_entry("sequence", &self.sequence)?;
write_tensor(map, "frames", self.frames.as_ref(), tensors)?;
write_tensor(map, "positions", self.positions.as_ref(), tensors)?;
map.serialize_entry("measure", &self.measure)?;
map.serialize_entry("error_m", &self.error_m)?;
if let Some(value) = &self.held_back_m { map.serialize_entry("held_back_m", value)?; }
map.serialize_entry("baseline_m", &self.baseline_m)?;

        Ok(())
    }
}
written!(crate::v1::FitPreview);

impl Fields for crate::v1::CancelFitRequest {
    const NAME: &'static str = "CancelFitRequest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::CancelFitRequest);

impl Fields for crate::v1::DeleteFitRequest {
    const NAME: &'static str = "DeleteFitRequest";
    const FIELDS: &'static [&'static str] = &["purge"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.purge = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("purge", &self.purge)?;

        Ok(())
    }
}
written!(crate::v1::DeleteFitRequest);

impl Fields for crate::v1::DeleteFitResponse {
    const NAME: &'static str = "DeleteFitResponse";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::DeleteFitResponse);

impl Fields for crate::v1::WatchFitRequest {
    const NAME: &'static str = "WatchFitRequest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::WatchFitRequest);

impl Fields for crate::v1::Twin {
    const NAME: &'static str = "Twin";
    const FIELDS: &'static [&'static str] = &["name", "display_name", "capture", "fit", "create_time", "size_bytes", "digest", "node_count", "spring_count", "triplet_count", "control_count", "fps", "substeps", "quality", "mass_kg", "note", "tags", "error_m", "owner"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.display_name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.capture = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.fit = map.next_value::<Option<_>>()?.unwrap_or_default(); }
4 => { self.create_time = time(map)?; }
5 => { self.size_bytes = map.next_value::<Option<_>>()?.unwrap_or_default(); }
6 => { self.digest = map.next_value::<Option<_>>()?.unwrap_or_default(); }
7 => { self.node_count = map.next_value::<Option<_>>()?.unwrap_or_default(); }
8 => { self.spring_count = map.next_value::<Option<_>>()?.unwrap_or_default(); }
9 => { self.triplet_count = map.next_value::<Option<_>>()?.unwrap_or_default(); }
10 => { self.control_count = map.next_value::<Option<_>>()?.unwrap_or_default(); }
11 => { self.fps = map.next_value::<Option<_>>()?.unwrap_or_default(); }
12 => { self.substeps = map.next_value::<Option<_>>()?.unwrap_or_default(); }
13 => { self.quality_json = document(map)?; }
14 => { self.mass_kg = map.next_value()?; }
15 => { self.note = map.next_value::<Option<_>>()?.unwrap_or_default(); }
16 => { self.tags = map.next_value::<Option<_>>()?.unwrap_or_default(); }
17 => { self.error_m = map.next_value()?; }
18 => { self.owner = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("name", &self.name)?;
map.serialize_entry("display_name", &self.display_name)?;
map.serialize_entry("capture", &filled(&self.capture))?;
map.serialize_entry("fit", &filled(&self.fit))?;
map.serialize_entry("create_time", &Time(self.create_time.unwrap_or_default()))?;
map.serialize_entry("size_bytes", &self.size_bytes)?;
map.serialize_entry("digest", &self.digest)?;
map.serialize_entry("node_count", &self.node_count)?;
map.serialize_entry("spring_count", &self.spring_count)?;
map.serialize_entry("triplet_count", &self.triplet_count)?;
map.serialize_entry("control_count", &self.control_count)?;
map.serialize_entry("fps", &self.fps)?;
map.serialize_entry("substeps", &self.substeps)?;
write_document(map, "quality", &self.quality_json)?;
if let Some(value) = &self.mass_kg { map.serialize_entry("mass_kg", value)?; }
map.serialize_entry("note", &self.note)?;
map.serialize_entry("tags", &self.tags)?;
map.serialize_entry("error_m", &self.error_m)?;
map.serialize_entry("owner", &self.owner)?;

        Ok(())
    }
}
written!(crate::v1::Twin);

impl Fields for crate::v1::GetTwinGeometryRequest {
    const NAME: &'static str = "GetTwinGeometryRequest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::GetTwinGeometryRequest);

impl Fields for crate::v1::TwinGeometry {
    const NAME: &'static str = "TwinGeometry";
    const FIELDS: &'static [&'static str] = &["rest_positions", "kinds", "edges", "rest_lengths", "triplets", "masses", "controls", "hands", "pins", "surface_count", "rod_count", "fps", "substeps", "gravity", "ground", "ground_friction", "ground_restitution", "mass_kg", "spacing_m", "rod_starts", "rod_nodes", "skin", "fits", "spring_stiffness", "bend_stiffness", "node_regions", "skin_sd"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.rest_positions = tensor(map, Dtype::Float32)?; }
1 => { self.kinds = tensor(map, Dtype::Float32)?; }
2 => { self.edges = tensor(map, Dtype::Float32)?; }
3 => { self.rest_lengths = tensor(map, Dtype::Float32)?; }
4 => { self.triplets = tensor(map, Dtype::Float32)?; }
5 => { self.masses = tensor(map, Dtype::Float32)?; }
6 => { self.controls = tensor(map, Dtype::Float32)?; }
7 => { self.hands = tensor(map, Dtype::Float32)?; }
8 => { self.pins = tensor(map, Dtype::Float32)?; }
9 => { self.surface_count = map.next_value::<Option<_>>()?.unwrap_or_default(); }
10 => { self.rod_count = map.next_value::<Option<_>>()?.unwrap_or_default(); }
11 => { self.fps = map.next_value::<Option<_>>()?.unwrap_or_default(); }
12 => { self.substeps = map.next_value::<Option<_>>()?.unwrap_or_default(); }
13 => { self.gravity = map.next_value::<Option<_>>()?.unwrap_or_default(); }
14 => { self.ground = message(map)?; }
15 => { self.ground_friction = map.next_value::<Option<_>>()?.unwrap_or_default(); }
16 => { self.ground_restitution = map.next_value::<Option<_>>()?.unwrap_or_default(); }
17 => { self.mass_kg = map.next_value()?; }
18 => { self.spacing_m = map.next_value::<Option<_>>()?.unwrap_or_default(); }
19 => { self.rod_starts = tensor(map, Dtype::Float32)?; }
20 => { self.rod_nodes = tensor(map, Dtype::Float32)?; }
21 => { self.skin = message(map)?; }
22 => { self.fits = map.next_value::<Option<_>>()?.unwrap_or_default(); }
23 => { self.spring_stiffness = tensor(map, Dtype::Float32)?; }
24 => { self.bend_stiffness = tensor(map, Dtype::Float32)?; }
25 => { self.node_regions = tensor(map, Dtype::Float32)?; }
26 => { self.skin_sd = tensor(map, Dtype::Float32)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_tensor(map, "rest_positions", self.rest_positions.as_ref(), tensors)?;
write_tensor(map, "kinds", self.kinds.as_ref(), tensors)?;
write_tensor(map, "edges", self.edges.as_ref(), tensors)?;
write_tensor(map, "rest_lengths", self.rest_lengths.as_ref(), tensors)?;
write_tensor(map, "triplets", self.triplets.as_ref(), tensors)?;
write_tensor(map, "masses", self.masses.as_ref(), tensors)?;
write_tensor(map, "controls", self.controls.as_ref(), tensors)?;
write_tensor(map, "hands", self.hands.as_ref(), tensors)?;
write_tensor(map, "pins", self.pins.as_ref(), tensors)?;
map.serialize_entry("surface_count", &self.surface_count)?;
map.serialize_entry("rod_count", &self.rod_count)?;
map.serialize_entry("fps", &self.fps)?;
map.serialize_entry("substeps", &self.substeps)?;
map.serialize_entry("gravity", &self.gravity)?;
write_message(map, "ground", self.ground.as_ref(), tensors)?;
map.serialize_entry("ground_friction", &self.ground_friction)?;
map.serialize_entry("ground_restitution", &self.ground_restitution)?;
if let Some(value) = &self.mass_kg { map.serialize_entry("mass_kg", value)?; }
map.serialize_entry("spacing_m", &self.spacing_m)?;
write_tensor(map, "rod_starts", self.rod_starts.as_ref(), tensors)?;
write_tensor(map, "rod_nodes", self.rod_nodes.as_ref(), tensors)?;
write_message(map, "skin", self.skin.as_ref(), tensors)?;
map.serialize_entry("fits", &self.fits)?;
write_tensor(map, "spring_stiffness", self.spring_stiffness.as_ref(), tensors)?;
write_tensor(map, "bend_stiffness", self.bend_stiffness.as_ref(), tensors)?;
write_tensor(map, "node_regions", self.node_regions.as_ref(), tensors)?;
write_tensor(map, "skin_sd", self.skin_sd.as_ref(), tensors)?;

        Ok(())
    }
}
written!(crate::v1::TwinGeometry);

impl Fields for crate::v1::twin_geometry::Skin {
    const NAME: &'static str = "Skin";
    const FIELDS: &'static [&'static str] = &["rest_positions", "observed_points", "weight_counts", "weight_nodes", "weights", "frames", "offsets"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.rest_positions = tensor(map, Dtype::Float32)?; }
1 => { self.observed_points = tensor(map, Dtype::Float32)?; }
2 => { self.weight_counts = tensor(map, Dtype::Float32)?; }
3 => { self.weight_nodes = tensor(map, Dtype::Float32)?; }
4 => { self.weights = tensor(map, Dtype::Float32)?; }
5 => { self.frames = tensor(map, Dtype::Float32)?; }
6 => { self.offsets = tensor(map, Dtype::Float32)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_tensor(map, "rest_positions", self.rest_positions.as_ref(), tensors)?;
write_tensor(map, "observed_points", self.observed_points.as_ref(), tensors)?;
write_tensor(map, "weight_counts", self.weight_counts.as_ref(), tensors)?;
write_tensor(map, "weight_nodes", self.weight_nodes.as_ref(), tensors)?;
write_tensor(map, "weights", self.weights.as_ref(), tensors)?;
write_tensor(map, "frames", self.frames.as_ref(), tensors)?;
write_tensor(map, "offsets", self.offsets.as_ref(), tensors)?;

        Ok(())
    }
}
written!(crate::v1::twin_geometry::Skin);

impl Fields for crate::v1::GetTwinSurfaceRequest {
    const NAME: &'static str = "GetTwinSurfaceRequest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::GetTwinSurfaceRequest);

impl Fields for crate::v1::TwinSurface {
    const NAME: &'static str = "TwinSurface";
    const FIELDS: &'static [&'static str] = &["carriers", "triangles", "colors", "tube_starts", "tube_nodes", "tube_radii", "node_count"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.carriers = message(map)?; }
1 => { self.triangles = tensor(map, Dtype::Float32)?; }
2 => { self.colors = tensor(map, Dtype::Float32)?; }
3 => { self.tube_starts = tensor(map, Dtype::Float32)?; }
4 => { self.tube_nodes = tensor(map, Dtype::Float32)?; }
5 => { self.tube_radii = tensor(map, Dtype::Float32)?; }
6 => { self.node_count = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_message(map, "carriers", self.carriers.as_ref(), tensors)?;
write_tensor(map, "triangles", self.triangles.as_ref(), tensors)?;
write_tensor(map, "colors", self.colors.as_ref(), tensors)?;
write_tensor(map, "tube_starts", self.tube_starts.as_ref(), tensors)?;
write_tensor(map, "tube_nodes", self.tube_nodes.as_ref(), tensors)?;
write_tensor(map, "tube_radii", self.tube_radii.as_ref(), tensors)?;
map.serialize_entry("node_count", &self.node_count)?;

        Ok(())
    }
}
written!(crate::v1::TwinSurface);

impl Fields for crate::v1::TwinMetadata {
    const NAME: &'static str = "TwinMetadata";
    const FIELDS: &'static [&'static str] = &["display_name", "digest"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.display_name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.digest = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("display_name", &self.display_name)?;
map.serialize_entry("digest", &self.digest)?;

        Ok(())
    }
}
written!(crate::v1::TwinMetadata);

impl Fields for crate::v1::GetTwinRequest {
    const NAME: &'static str = "GetTwinRequest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::GetTwinRequest);

impl Fields for crate::v1::ListTwinsRequest {
    const NAME: &'static str = "ListTwinsRequest";
    const FIELDS: &'static [&'static str] = &["page_size", "page_token", "capture", "search", "tag", "order_by", "owner", "level"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.page_size = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.page_token = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.capture = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.search = map.next_value::<Option<_>>()?.unwrap_or_default(); }
4 => { self.tag = map.next_value::<Option<_>>()?.unwrap_or_default(); }
5 => { self.order_by = map.next_value::<Option<_>>()?.unwrap_or_default(); }
6 => { self.owner = map.next_value::<Option<_>>()?.unwrap_or_default(); }
7 => { self.level = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("page_size", &self.page_size)?;
map.serialize_entry("page_token", &self.page_token)?;
map.serialize_entry("capture", &self.capture)?;
map.serialize_entry("search", &self.search)?;
map.serialize_entry("tag", &self.tag)?;
map.serialize_entry("order_by", &self.order_by)?;
map.serialize_entry("owner", &self.owner)?;
map.serialize_entry("level", &self.level)?;

        Ok(())
    }
}
written!(crate::v1::ListTwinsRequest);

impl Fields for crate::v1::ListTwinsResponse {
    const NAME: &'static str = "ListTwinsResponse";
    const FIELDS: &'static [&'static str] = &["twins", "next_page_token", "total_size"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.twins = messages(map)?; }
1 => { self.next_page_token = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.total_size = map.next_value()?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_messages(map, "twins", &self.twins, tensors)?;
map.serialize_entry("next_page_token", &self.next_page_token)?;
if let Some(value) = &self.total_size { map.serialize_entry("total_size", value)?; }

        Ok(())
    }
}
written!(crate::v1::ListTwinsResponse);

impl Fields for crate::v1::UpdateTwinRequest {
    const NAME: &'static str = "UpdateTwinRequest";
    const FIELDS: &'static [&'static str] = &["display_name", "note", "tags", "add_tags", "remove_tags"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { if let Some(value) = map.next_value::<Option<_>>()? { self.twin.get_or_insert_default().display_name = value; self.update_mask.get_or_insert_default().paths.push("display_name".to_owned()); } }
1 => { if let Some(value) = map.next_value::<Option<_>>()? { self.twin.get_or_insert_default().note = value; self.update_mask.get_or_insert_default().paths.push("note".to_owned()); } }
2 => { if let Some(value) = map.next_value::<Option<_>>()? { self.twin.get_or_insert_default().tags = value; self.update_mask.get_or_insert_default().paths.push("tags".to_owned()); } }
3 => { self.add_tags = map.next_value::<Option<_>>()?.unwrap_or_default(); }
4 => { self.remove_tags = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        


map.serialize_entry("add_tags", &self.add_tags)?;
map.serialize_entry("remove_tags", &self.remove_tags)?;

        Ok(())
    }
}
written!(crate::v1::UpdateTwinRequest);

impl Fields for crate::v1::DeleteTwinRequest {
    const NAME: &'static str = "DeleteTwinRequest";
    const FIELDS: &'static [&'static str] = &["purge"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.purge = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("purge", &self.purge)?;

        Ok(())
    }
}
written!(crate::v1::DeleteTwinRequest);

impl Fields for crate::v1::DeleteTwinResponse {
    const NAME: &'static str = "DeleteTwinResponse";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::DeleteTwinResponse);

impl Fields for crate::v1::TrashedResource {
    const NAME: &'static str = "TrashedResource";
    const FIELDS: &'static [&'static str] = &["name", "display_name", "owner", "create_time", "delete_time", "purge_time", "deleted_by", "size_bytes"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.display_name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.owner = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.create_time = time(map)?; }
4 => { self.delete_time = time(map)?; }
5 => { self.purge_time = time(map)?; }
6 => { self.deleted_by = map.next_value::<Option<_>>()?.unwrap_or_default(); }
7 => { self.size_bytes = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("name", &self.name)?;
map.serialize_entry("display_name", &self.display_name)?;
map.serialize_entry("owner", &self.owner)?;
map.serialize_entry("create_time", &Time(self.create_time.unwrap_or_default()))?;
map.serialize_entry("delete_time", &Time(self.delete_time.unwrap_or_default()))?;
map.serialize_entry("purge_time", &Time(self.purge_time.unwrap_or_default()))?;
map.serialize_entry("deleted_by", &self.deleted_by)?;
map.serialize_entry("size_bytes", &self.size_bytes)?;

        Ok(())
    }
}
written!(crate::v1::TrashedResource);

impl Fields for crate::v1::ListTrashedCapturesRequest {
    const NAME: &'static str = "ListTrashedCapturesRequest";
    const FIELDS: &'static [&'static str] = &["page_size", "page_token", "owner"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.page_size = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.page_token = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.owner = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("page_size", &self.page_size)?;
map.serialize_entry("page_token", &self.page_token)?;
map.serialize_entry("owner", &self.owner)?;

        Ok(())
    }
}
written!(crate::v1::ListTrashedCapturesRequest);

impl Fields for crate::v1::ListTrashedCapturesResponse {
    const NAME: &'static str = "ListTrashedCapturesResponse";
    const FIELDS: &'static [&'static str] = &["resources", "next_page_token"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.resources = messages(map)?; }
1 => { self.next_page_token = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_messages(map, "resources", &self.resources, tensors)?;
map.serialize_entry("next_page_token", &self.next_page_token)?;

        Ok(())
    }
}
written!(crate::v1::ListTrashedCapturesResponse);

impl Fields for crate::v1::UndeleteCaptureRequest {
    const NAME: &'static str = "UndeleteCaptureRequest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::UndeleteCaptureRequest);

impl Fields for crate::v1::ListTrashedFitsRequest {
    const NAME: &'static str = "ListTrashedFitsRequest";
    const FIELDS: &'static [&'static str] = &["page_size", "page_token", "owner"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.page_size = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.page_token = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.owner = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("page_size", &self.page_size)?;
map.serialize_entry("page_token", &self.page_token)?;
map.serialize_entry("owner", &self.owner)?;

        Ok(())
    }
}
written!(crate::v1::ListTrashedFitsRequest);

impl Fields for crate::v1::ListTrashedFitsResponse {
    const NAME: &'static str = "ListTrashedFitsResponse";
    const FIELDS: &'static [&'static str] = &["resources", "next_page_token"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.resources = messages(map)?; }
1 => { self.next_page_token = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_messages(map, "resources", &self.resources, tensors)?;
map.serialize_entry("next_page_token", &self.next_page_token)?;

        Ok(())
    }
}
written!(crate::v1::ListTrashedFitsResponse);

impl Fields for crate::v1::UndeleteFitRequest {
    const NAME: &'static str = "UndeleteFitRequest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::UndeleteFitRequest);

impl Fields for crate::v1::ListTrashedTwinsRequest {
    const NAME: &'static str = "ListTrashedTwinsRequest";
    const FIELDS: &'static [&'static str] = &["page_size", "page_token", "owner"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.page_size = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.page_token = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.owner = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("page_size", &self.page_size)?;
map.serialize_entry("page_token", &self.page_token)?;
map.serialize_entry("owner", &self.owner)?;

        Ok(())
    }
}
written!(crate::v1::ListTrashedTwinsRequest);

impl Fields for crate::v1::ListTrashedTwinsResponse {
    const NAME: &'static str = "ListTrashedTwinsResponse";
    const FIELDS: &'static [&'static str] = &["resources", "next_page_token"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.resources = messages(map)?; }
1 => { self.next_page_token = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_messages(map, "resources", &self.resources, tensors)?;
map.serialize_entry("next_page_token", &self.next_page_token)?;

        Ok(())
    }
}
written!(crate::v1::ListTrashedTwinsResponse);

impl Fields for crate::v1::UndeleteTwinRequest {
    const NAME: &'static str = "UndeleteTwinRequest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::UndeleteTwinRequest);

impl Fields for crate::v1::RetentionRule {
    const NAME: &'static str = "RetentionRule";
    const FIELDS: &'static [&'static str] = &["name", "display_name", "collection", "min_age_days", "owner", "tag", "verdict", "create_time"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.display_name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.collection = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.min_age_days = map.next_value::<Option<_>>()?.unwrap_or_default(); }
4 => { self.owner = map.next_value::<Option<_>>()?.unwrap_or_default(); }
5 => { self.tag = map.next_value::<Option<_>>()?.unwrap_or_default(); }
6 => { self.verdict = map.next_value::<Option<_>>()?.unwrap_or_default(); }
7 => { self.create_time = time(map)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("name", &filled(&self.name))?;
map.serialize_entry("display_name", &self.display_name)?;
map.serialize_entry("collection", &self.collection)?;
map.serialize_entry("min_age_days", &self.min_age_days)?;
map.serialize_entry("owner", &self.owner)?;
map.serialize_entry("tag", &self.tag)?;
map.serialize_entry("verdict", &self.verdict)?;
map.serialize_entry("create_time", &self.create_time.map(Time))?;

        Ok(())
    }
}
written!(crate::v1::RetentionRule);

impl Fields for crate::v1::CreateRetentionRuleRequest {
    const NAME: &'static str = "CreateRetentionRuleRequest";
    const FIELDS: &'static [&'static str] = &["display_name", "collection", "min_age_days", "owner", "tag", "verdict"];
    const REQUIRED: &'static [&'static str] = &["display_name", "collection", "min_age_days"];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.display_name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.collection = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.min_age_days = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.owner = map.next_value::<Option<_>>()?.unwrap_or_default(); }
4 => { self.tag = map.next_value::<Option<_>>()?.unwrap_or_default(); }
5 => { self.verdict = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("display_name", &self.display_name)?;
map.serialize_entry("collection", &self.collection)?;
map.serialize_entry("min_age_days", &self.min_age_days)?;
map.serialize_entry("owner", &self.owner)?;
map.serialize_entry("tag", &self.tag)?;
map.serialize_entry("verdict", &self.verdict)?;

        Ok(())
    }
}
written!(crate::v1::CreateRetentionRuleRequest);

impl Fields for crate::v1::GetRetentionRuleRequest {
    const NAME: &'static str = "GetRetentionRuleRequest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::GetRetentionRuleRequest);

impl Fields for crate::v1::ListRetentionRulesRequest {
    const NAME: &'static str = "ListRetentionRulesRequest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::ListRetentionRulesRequest);

impl Fields for crate::v1::ListRetentionRulesResponse {
    const NAME: &'static str = "ListRetentionRulesResponse";
    const FIELDS: &'static [&'static str] = &["rules"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.rules = messages(map)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_messages(map, "rules", &self.rules, tensors)?;

        Ok(())
    }
}
written!(crate::v1::ListRetentionRulesResponse);

impl Fields for crate::v1::DeleteRetentionRuleRequest {
    const NAME: &'static str = "DeleteRetentionRuleRequest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::DeleteRetentionRuleRequest);

impl Fields for crate::v1::DeleteRetentionRuleResponse {
    const NAME: &'static str = "DeleteRetentionRuleResponse";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::DeleteRetentionRuleResponse);

impl Fields for crate::v1::PreviewRetentionRequest {
    const NAME: &'static str = "PreviewRetentionRequest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::PreviewRetentionRequest);

impl Fields for crate::v1::PreviewRetentionResponse {
    const NAME: &'static str = "PreviewRetentionResponse";
    const FIELDS: &'static [&'static str] = &["outcomes", "truncated"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.outcomes = messages(map)?; }
1 => { self.truncated = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_messages(map, "outcomes", &self.outcomes, tensors)?;
map.serialize_entry("truncated", &self.truncated)?;

        Ok(())
    }
}
written!(crate::v1::PreviewRetentionResponse);

impl Fields for crate::v1::RetentionOutcome {
    const NAME: &'static str = "RetentionOutcome";
    const FIELDS: &'static [&'static str] = &["name", "display_name", "owner", "create_time", "size_bytes", "rule", "kept_because"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.display_name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.owner = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.create_time = time(map)?; }
4 => { self.size_bytes = map.next_value::<Option<_>>()?.unwrap_or_default(); }
5 => { self.rule = map.next_value::<Option<_>>()?.unwrap_or_default(); }
6 => { self.kept_because = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("name", &self.name)?;
map.serialize_entry("display_name", &self.display_name)?;
map.serialize_entry("owner", &self.owner)?;
map.serialize_entry("create_time", &Time(self.create_time.unwrap_or_default()))?;
map.serialize_entry("size_bytes", &self.size_bytes)?;
map.serialize_entry("rule", &self.rule)?;
map.serialize_entry("kept_because", &self.kept_because)?;

        Ok(())
    }
}
written!(crate::v1::RetentionOutcome);

impl Fields for crate::v1::Worker {
    const NAME: &'static str = "Worker";
    const FIELDS: &'static [&'static str] = &["name", "backend", "device", "start_time", "last_seen_time", "fit", "warm_twins", "rollouts_in_flight", "build", "memory_used_bytes", "memory_total_bytes", "ingest", "draining", "server", "labels"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.backend = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.device = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.start_time = time(map)?; }
4 => { self.last_seen_time = time(map)?; }
5 => { self.fit = map.next_value::<Option<_>>()?.unwrap_or_default(); }
6 => { self.warm_twins = map.next_value::<Option<_>>()?.unwrap_or_default(); }
7 => { self.rollouts_in_flight = map.next_value::<Option<_>>()?.unwrap_or_default(); }
8 => { self.build = map.next_value::<Option<_>>()?.unwrap_or_default(); }
9 => { self.memory_used_bytes = map.next_value::<Option<_>>()?.unwrap_or_default(); }
10 => { self.memory_total_bytes = map.next_value::<Option<_>>()?.unwrap_or_default(); }
11 => { self.ingest = map.next_value::<Option<_>>()?.unwrap_or_default(); }
12 => { self.draining = map.next_value::<Option<_>>()?.unwrap_or_default(); }
13 => { self.server = map.next_value::<Option<_>>()?.unwrap_or_default(); }
14 => { self.labels = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("name", &self.name)?;
map.serialize_entry("backend", &self.backend)?;
map.serialize_entry("device", &self.device)?;
map.serialize_entry("start_time", &Time(self.start_time.unwrap_or_default()))?;
map.serialize_entry("last_seen_time", &Time(self.last_seen_time.unwrap_or_default()))?;
map.serialize_entry("fit", &filled(&self.fit))?;
map.serialize_entry("warm_twins", &self.warm_twins)?;
map.serialize_entry("rollouts_in_flight", &self.rollouts_in_flight)?;
map.serialize_entry("build", &self.build)?;
map.serialize_entry("memory_used_bytes", &filled(&self.memory_used_bytes))?;
map.serialize_entry("memory_total_bytes", &filled(&self.memory_total_bytes))?;
map.serialize_entry("ingest", &filled(&self.ingest))?;
map.serialize_entry("draining", &self.draining)?;
map.serialize_entry("server", &filled(&self.server))?;
map.serialize_entry("labels", &self.labels)?;

        Ok(())
    }
}
written!(crate::v1::Worker);

impl Fields for crate::v1::GetWorkerRequest {
    const NAME: &'static str = "GetWorkerRequest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::GetWorkerRequest);

impl Fields for crate::v1::DrainWorkerRequest {
    const NAME: &'static str = "DrainWorkerRequest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::DrainWorkerRequest);

impl Fields for crate::v1::ListWorkersRequest {
    const NAME: &'static str = "ListWorkersRequest";
    const FIELDS: &'static [&'static str] = &["page_size", "page_token"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.page_size = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.page_token = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("page_size", &self.page_size)?;
map.serialize_entry("page_token", &self.page_token)?;

        Ok(())
    }
}
written!(crate::v1::ListWorkersRequest);

impl Fields for crate::v1::ListWorkersResponse {
    const NAME: &'static str = "ListWorkersResponse";
    const FIELDS: &'static [&'static str] = &["workers", "next_page_token"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.workers = messages(map)?; }
1 => { self.next_page_token = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_messages(map, "workers", &self.workers, tensors)?;
map.serialize_entry("next_page_token", &self.next_page_token)?;

        Ok(())
    }
}
written!(crate::v1::ListWorkersResponse);

impl Fields for crate::v1::Key {
    const NAME: &'static str = "Key";
    const FIELDS: &'static [&'static str] = &["name", "display_name", "owner", "scopes", "create_time", "expire_time", "revoke_time", "last_use_time", "quotas", "is_sign_in", "twin"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.display_name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.owner = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.scopes = map.next_value::<Option<_>>()?.unwrap_or_default(); }
4 => { self.create_time = time(map)?; }
5 => { self.expire_time = time(map)?; }
6 => { self.revoke_time = time(map)?; }
7 => { self.last_use_time = time(map)?; }
8 => { self.quotas = message(map)?; }
9 => { self.is_sign_in = map.next_value::<Option<_>>()?.unwrap_or_default(); }
10 => { self.twin = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("name", &self.name)?;
map.serialize_entry("display_name", &self.display_name)?;
map.serialize_entry("owner", &self.owner)?;
map.serialize_entry("scopes", &self.scopes)?;
map.serialize_entry("create_time", &Time(self.create_time.unwrap_or_default()))?;
map.serialize_entry("expire_time", &self.expire_time.map(Time))?;
map.serialize_entry("revoke_time", &self.revoke_time.map(Time))?;
map.serialize_entry("last_use_time", &self.last_use_time.map(Time))?;
write_message(map, "quotas", Some(self.quotas.as_ref().unwrap_or(&Default::default())), tensors)?;
map.serialize_entry("is_sign_in", &self.is_sign_in)?;
map.serialize_entry("twin", &filled(&self.twin))?;

        Ok(())
    }
}
written!(crate::v1::Key);

impl Fields for crate::v1::KeyQuotas {
    const NAME: &'static str = "KeyQuotas";
    const FIELDS: &'static [&'static str] = &["queued_jobs", "stored_bytes", "rollouts", "running_jobs", "fit_run_s", "priority"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.queued_jobs = map.next_value()?; }
1 => { self.stored_bytes = map.next_value()?; }
2 => { self.rollouts = map.next_value()?; }
3 => { self.running_jobs = map.next_value()?; }
4 => { self.fit_run_s = map.next_value()?; }
5 => { self.priority = map.next_value()?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("queued_jobs", &self.queued_jobs)?;
map.serialize_entry("stored_bytes", &self.stored_bytes)?;
map.serialize_entry("rollouts", &self.rollouts)?;
map.serialize_entry("running_jobs", &self.running_jobs)?;
map.serialize_entry("fit_run_s", &self.fit_run_s)?;
map.serialize_entry("priority", &self.priority)?;

        Ok(())
    }
}
written!(crate::v1::KeyQuotas);

impl Fields for crate::v1::CreateKeyRequest {
    const NAME: &'static str = "CreateKeyRequest";
    const FIELDS: &'static [&'static str] = &["display_name", "owner", "scopes", "expire_time", "quotas"];
    const REQUIRED: &'static [&'static str] = &["display_name", "scopes"];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.display_name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.owner = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.scopes = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.expire_time = time(map)?; }
4 => { self.quotas = message(map)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("display_name", &self.display_name)?;
map.serialize_entry("owner", &self.owner)?;
map.serialize_entry("scopes", &self.scopes)?;
if let Some(time) = self.expire_time { map.serialize_entry("expire_time", &Time(time))?; }
write_message(map, "quotas", self.quotas.as_ref(), tensors)?;

        Ok(())
    }
}
written!(crate::v1::CreateKeyRequest);

impl Fields for crate::v1::CreateKeyResponse {
    const NAME: &'static str = "CreateKeyResponse";
    const FIELDS: &'static [&'static str] = &["key", "secret_key"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.key = message(map)?; }
1 => { self.secret_key = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_message(map, "key", Some(self.key.as_ref().unwrap_or(&Default::default())), tensors)?;
map.serialize_entry("secret_key", &self.secret_key)?;

        Ok(())
    }
}
written!(crate::v1::CreateKeyResponse);

impl Fields for crate::v1::GetKeyRequest {
    const NAME: &'static str = "GetKeyRequest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::GetKeyRequest);

impl Fields for crate::v1::ListKeysRequest {
    const NAME: &'static str = "ListKeysRequest";
    const FIELDS: &'static [&'static str] = &["page_size", "page_token"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.page_size = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.page_token = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("page_size", &self.page_size)?;
map.serialize_entry("page_token", &self.page_token)?;

        Ok(())
    }
}
written!(crate::v1::ListKeysRequest);

impl Fields for crate::v1::ListKeysResponse {
    const NAME: &'static str = "ListKeysResponse";
    const FIELDS: &'static [&'static str] = &["keys", "next_page_token"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.keys = messages(map)?; }
1 => { self.next_page_token = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_messages(map, "keys", &self.keys, tensors)?;
map.serialize_entry("next_page_token", &self.next_page_token)?;

        Ok(())
    }
}
written!(crate::v1::ListKeysResponse);

impl Fields for crate::v1::DeleteKeyRequest {
    const NAME: &'static str = "DeleteKeyRequest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::DeleteKeyRequest);

impl Fields for crate::v1::DeleteKeyResponse {
    const NAME: &'static str = "DeleteKeyResponse";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::DeleteKeyResponse);

impl Fields for crate::v1::Share {
    const NAME: &'static str = "Share";
    const FIELDS: &'static [&'static str] = &["name", "twin", "display_name", "owner", "allow_export", "create_time", "expire_time", "revoke_time", "last_use_time"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.twin = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.display_name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.owner = map.next_value::<Option<_>>()?.unwrap_or_default(); }
4 => { self.allow_export = map.next_value::<Option<_>>()?.unwrap_or_default(); }
5 => { self.create_time = time(map)?; }
6 => { self.expire_time = time(map)?; }
7 => { self.revoke_time = time(map)?; }
8 => { self.last_use_time = time(map)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("name", &self.name)?;
map.serialize_entry("twin", &self.twin)?;
map.serialize_entry("display_name", &self.display_name)?;
map.serialize_entry("owner", &self.owner)?;
map.serialize_entry("allow_export", &self.allow_export)?;
map.serialize_entry("create_time", &Time(self.create_time.unwrap_or_default()))?;
map.serialize_entry("expire_time", &Time(self.expire_time.unwrap_or_default()))?;
map.serialize_entry("revoke_time", &self.revoke_time.map(Time))?;
map.serialize_entry("last_use_time", &self.last_use_time.map(Time))?;

        Ok(())
    }
}
written!(crate::v1::Share);

impl Fields for crate::v1::ShareTwinRequest {
    const NAME: &'static str = "ShareTwinRequest";
    const FIELDS: &'static [&'static str] = &["display_name", "ttl_s", "expire_time", "allow_export"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.display_name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.ttl_s = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.expire_time = time(map)?; }
3 => { self.allow_export = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("display_name", &self.display_name)?;
map.serialize_entry("ttl_s", &self.ttl_s)?;
if let Some(time) = self.expire_time { map.serialize_entry("expire_time", &Time(time))?; }
map.serialize_entry("allow_export", &self.allow_export)?;

        Ok(())
    }
}
written!(crate::v1::ShareTwinRequest);

impl Fields for crate::v1::ShareTwinResponse {
    const NAME: &'static str = "ShareTwinResponse";
    const FIELDS: &'static [&'static str] = &["share", "secret_key"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.share = message(map)?; }
1 => { self.secret_key = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_message(map, "share", Some(self.share.as_ref().unwrap_or(&Default::default())), tensors)?;
map.serialize_entry("secret_key", &self.secret_key)?;

        Ok(())
    }
}
written!(crate::v1::ShareTwinResponse);

impl Fields for crate::v1::ListSharesRequest {
    const NAME: &'static str = "ListSharesRequest";
    const FIELDS: &'static [&'static str] = &["page_size", "page_token"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.page_size = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.page_token = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("page_size", &self.page_size)?;
map.serialize_entry("page_token", &self.page_token)?;

        Ok(())
    }
}
written!(crate::v1::ListSharesRequest);

impl Fields for crate::v1::ListSharesResponse {
    const NAME: &'static str = "ListSharesResponse";
    const FIELDS: &'static [&'static str] = &["shares", "next_page_token"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.shares = messages(map)?; }
1 => { self.next_page_token = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_messages(map, "shares", &self.shares, tensors)?;
map.serialize_entry("next_page_token", &self.next_page_token)?;

        Ok(())
    }
}
written!(crate::v1::ListSharesResponse);

impl Fields for crate::v1::DeleteShareRequest {
    const NAME: &'static str = "DeleteShareRequest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::DeleteShareRequest);

impl Fields for crate::v1::DeleteShareResponse {
    const NAME: &'static str = "DeleteShareResponse";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::DeleteShareResponse);

impl Fields for crate::v1::Project {
    const NAME: &'static str = "Project";
    const FIELDS: &'static [&'static str] = &["name", "display_name", "members", "create_time"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.display_name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.members = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.create_time = time(map)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("name", &self.name)?;
map.serialize_entry("display_name", &self.display_name)?;
map.serialize_entry("members", &self.members)?;
map.serialize_entry("create_time", &Time(self.create_time.unwrap_or_default()))?;

        Ok(())
    }
}
written!(crate::v1::Project);

impl Fields for crate::v1::CreateProjectRequest {
    const NAME: &'static str = "CreateProjectRequest";
    const FIELDS: &'static [&'static str] = &["display_name", "members"];
    const REQUIRED: &'static [&'static str] = &["display_name"];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.display_name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.members = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("display_name", &self.display_name)?;
map.serialize_entry("members", &self.members)?;

        Ok(())
    }
}
written!(crate::v1::CreateProjectRequest);

impl Fields for crate::v1::GetProjectRequest {
    const NAME: &'static str = "GetProjectRequest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::GetProjectRequest);

impl Fields for crate::v1::ListProjectsRequest {
    const NAME: &'static str = "ListProjectsRequest";
    const FIELDS: &'static [&'static str] = &["page_size", "page_token"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.page_size = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.page_token = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("page_size", &self.page_size)?;
map.serialize_entry("page_token", &self.page_token)?;

        Ok(())
    }
}
written!(crate::v1::ListProjectsRequest);

impl Fields for crate::v1::ListProjectsResponse {
    const NAME: &'static str = "ListProjectsResponse";
    const FIELDS: &'static [&'static str] = &["projects", "next_page_token"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.projects = messages(map)?; }
1 => { self.next_page_token = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_messages(map, "projects", &self.projects, tensors)?;
map.serialize_entry("next_page_token", &self.next_page_token)?;

        Ok(())
    }
}
written!(crate::v1::ListProjectsResponse);

impl Fields for crate::v1::UpdateProjectRequest {
    const NAME: &'static str = "UpdateProjectRequest";
    const FIELDS: &'static [&'static str] = &["display_name", "members", "add_members", "remove_members"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { if let Some(value) = map.next_value::<Option<_>>()? { self.project.get_or_insert_default().display_name = value; self.update_mask.get_or_insert_default().paths.push("display_name".to_owned()); } }
1 => { if let Some(value) = map.next_value::<Option<_>>()? { self.project.get_or_insert_default().members = value; self.update_mask.get_or_insert_default().paths.push("members".to_owned()); } }
2 => { self.add_members = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.remove_members = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        

map.serialize_entry("add_members", &self.add_members)?;
map.serialize_entry("remove_members", &self.remove_members)?;

        Ok(())
    }
}
written!(crate::v1::UpdateProjectRequest);

impl Fields for crate::v1::DeleteProjectRequest {
    const NAME: &'static str = "DeleteProjectRequest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::DeleteProjectRequest);

impl Fields for crate::v1::DeleteProjectResponse {
    const NAME: &'static str = "DeleteProjectResponse";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::DeleteProjectResponse);

impl Fields for crate::v1::OwnerUsage {
    const NAME: &'static str = "OwnerUsage";
    const FIELDS: &'static [&'static str] = &["owner", "captures", "fits", "twins", "stored_bytes", "queued_jobs", "running_jobs", "quotas"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.owner = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.captures = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.fits = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.twins = map.next_value::<Option<_>>()?.unwrap_or_default(); }
4 => { self.stored_bytes = message(map)?; }
5 => { self.queued_jobs = map.next_value::<Option<_>>()?.unwrap_or_default(); }
6 => { self.running_jobs = map.next_value::<Option<_>>()?.unwrap_or_default(); }
7 => { self.quotas = message(map)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("owner", &self.owner)?;
map.serialize_entry("captures", &self.captures)?;
map.serialize_entry("fits", &self.fits)?;
map.serialize_entry("twins", &self.twins)?;
write_message(map, "stored_bytes", Some(self.stored_bytes.as_ref().unwrap_or(&Default::default())), tensors)?;
map.serialize_entry("queued_jobs", &self.queued_jobs)?;
map.serialize_entry("running_jobs", &self.running_jobs)?;
write_message(map, "quotas", Some(self.quotas.as_ref().unwrap_or(&Default::default())), tensors)?;

        Ok(())
    }
}
written!(crate::v1::OwnerUsage);

impl Fields for crate::v1::StoredBytes {
    const NAME: &'static str = "StoredBytes";
    const FIELDS: &'static [&'static str] = &["total", "captures", "derived", "twins", "checkpoints", "uploads"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.total = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.captures = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.derived = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.twins = map.next_value::<Option<_>>()?.unwrap_or_default(); }
4 => { self.checkpoints = map.next_value::<Option<_>>()?.unwrap_or_default(); }
5 => { self.uploads = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("total", &self.total)?;
map.serialize_entry("captures", &self.captures)?;
map.serialize_entry("derived", &self.derived)?;
map.serialize_entry("twins", &self.twins)?;
map.serialize_entry("checkpoints", &self.checkpoints)?;
map.serialize_entry("uploads", &self.uploads)?;

        Ok(())
    }
}
written!(crate::v1::StoredBytes);

impl Fields for crate::v1::GetUsageRequest {
    const NAME: &'static str = "GetUsageRequest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::GetUsageRequest);

impl Fields for crate::v1::ListOwnerUsageRequest {
    const NAME: &'static str = "ListOwnerUsageRequest";
    const FIELDS: &'static [&'static str] = &["page_size", "page_token"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.page_size = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.page_token = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("page_size", &self.page_size)?;
map.serialize_entry("page_token", &self.page_token)?;

        Ok(())
    }
}
written!(crate::v1::ListOwnerUsageRequest);

impl Fields for crate::v1::ListOwnerUsageResponse {
    const NAME: &'static str = "ListOwnerUsageResponse";
    const FIELDS: &'static [&'static str] = &["owners", "next_page_token"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.owners = messages(map)?; }
1 => { self.next_page_token = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_messages(map, "owners", &self.owners, tensors)?;
map.serialize_entry("next_page_token", &self.next_page_token)?;

        Ok(())
    }
}
written!(crate::v1::ListOwnerUsageResponse);

impl Fields for crate::v1::GetSignInOptionsRequest {
    const NAME: &'static str = "GetSignInOptionsRequest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::GetSignInOptionsRequest);

impl Fields for crate::v1::SignInOptions {
    const NAME: &'static str = "SignInOptions";
    const FIELDS: &'static [&'static str] = &["enabled", "display_name", "public_url"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.enabled = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.display_name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.public_url = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("enabled", &self.enabled)?;
map.serialize_entry("display_name", &self.display_name)?;
map.serialize_entry("public_url", &self.public_url)?;

        Ok(())
    }
}
written!(crate::v1::SignInOptions);

impl Fields for crate::v1::StartSignInRequest {
    const NAME: &'static str = "StartSignInRequest";
    const FIELDS: &'static [&'static str] = &["state", "nonce", "code_challenge"];
    const REQUIRED: &'static [&'static str] = &["state", "nonce", "code_challenge"];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.state = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.nonce = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.code_challenge = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("state", &self.state)?;
map.serialize_entry("nonce", &self.nonce)?;
map.serialize_entry("code_challenge", &self.code_challenge)?;

        Ok(())
    }
}
written!(crate::v1::StartSignInRequest);

impl Fields for crate::v1::StartSignInResponse {
    const NAME: &'static str = "StartSignInResponse";
    const FIELDS: &'static [&'static str] = &["authorization_url"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.authorization_url = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("authorization_url", &self.authorization_url)?;

        Ok(())
    }
}
written!(crate::v1::StartSignInResponse);

impl Fields for crate::v1::StartDeviceSignInRequest {
    const NAME: &'static str = "StartDeviceSignInRequest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::StartDeviceSignInRequest);

impl Fields for crate::v1::StartDeviceSignInResponse {
    const NAME: &'static str = "StartDeviceSignInResponse";
    const FIELDS: &'static [&'static str] = &["device_code", "user_code", "verification_uri", "verification_uri_complete", "interval_s", "expires_in_s"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.device_code = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.user_code = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.verification_uri = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.verification_uri_complete = map.next_value::<Option<_>>()?.unwrap_or_default(); }
4 => { self.interval_s = map.next_value::<Option<_>>()?.unwrap_or_default(); }
5 => { self.expires_in_s = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("device_code", &self.device_code)?;
map.serialize_entry("user_code", &self.user_code)?;
map.serialize_entry("verification_uri", &self.verification_uri)?;
map.serialize_entry("verification_uri_complete", &self.verification_uri_complete)?;
map.serialize_entry("interval_s", &self.interval_s)?;
map.serialize_entry("expires_in_s", &self.expires_in_s)?;

        Ok(())
    }
}
written!(crate::v1::StartDeviceSignInResponse);

impl Fields for crate::v1::CreateSignInRequest {
    const NAME: &'static str = "CreateSignInRequest";
    const FIELDS: &'static [&'static str] = &["code", "code_verifier", "nonce", "device_code"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.code = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.code_verifier = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.nonce = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.device_code = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("code", &self.code)?;
map.serialize_entry("code_verifier", &self.code_verifier)?;
map.serialize_entry("nonce", &self.nonce)?;
map.serialize_entry("device_code", &self.device_code)?;

        Ok(())
    }
}
written!(crate::v1::CreateSignInRequest);

impl Fields for crate::v1::CreateSignInResponse {
    const NAME: &'static str = "CreateSignInResponse";
    const FIELDS: &'static [&'static str] = &["key", "secret_key"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.key = message(map)?; }
1 => { self.secret_key = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_message(map, "key", Some(self.key.as_ref().unwrap_or(&Default::default())), tensors)?;
map.serialize_entry("secret_key", &self.secret_key)?;

        Ok(())
    }
}
written!(crate::v1::CreateSignInResponse);

impl Fields for crate::v1::DeleteSignInRequest {
    const NAME: &'static str = "DeleteSignInRequest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::DeleteSignInRequest);

impl Fields for crate::v1::DeleteSignInResponse {
    const NAME: &'static str = "DeleteSignInResponse";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::DeleteSignInResponse);

impl Fields for crate::v1::GetCallerRequest {
    const NAME: &'static str = "GetCallerRequest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::GetCallerRequest);

impl Fields for crate::v1::Caller {
    const NAME: &'static str = "Caller";
    const FIELDS: &'static [&'static str] = &["owner", "scopes", "key", "is_sign_in", "expire_time"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.owner = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.scopes = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.key = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.is_sign_in = map.next_value::<Option<_>>()?.unwrap_or_default(); }
4 => { self.expire_time = time(map)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("owner", &self.owner)?;
map.serialize_entry("scopes", &self.scopes)?;
map.serialize_entry("key", &self.key)?;
map.serialize_entry("is_sign_in", &self.is_sign_in)?;
map.serialize_entry("expire_time", &self.expire_time.map(Time))?;

        Ok(())
    }
}
written!(crate::v1::Caller);

impl Fields for crate::v1::RollOutRequest {
    const NAME: &'static str = "RollOutRequest";
    const FIELDS: &'static [&'static str] = &["twin", "trajectories", "poses", "initial", "frames", "costs", "returns", "fidelity", "world", "grasps", "vary", "ensemble", "gradient", "plausibility", "knot_times", "time_limit_s"];
    const REQUIRED: &'static [&'static str] = &[];
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
8 => { self.world = message(map)?; }
9 => { self.grasps = messages(map)?; }
10 => { self.vary = message(map)?; }
11 => { self.ensemble = message(map)?; }
12 => { self.gradient = message(map)?; }
13 => { self.plausibility = message(map)?; }
14 => { self.knot_times = message(map)?; }
15 => { self.time_limit_s = map.next_value()?; }

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
write_message(map, "world", self.world.as_ref(), tensors)?;
write_messages(map, "grasps", &self.grasps, tensors)?;
write_message(map, "vary", self.vary.as_ref(), tensors)?;
write_message(map, "ensemble", self.ensemble.as_ref(), tensors)?;
write_message(map, "gradient", self.gradient.as_ref(), tensors)?;
write_message(map, "plausibility", self.plausibility.as_ref(), tensors)?;
write_message(map, "knot_times", self.knot_times.as_ref(), tensors)?;
if let Some(value) = &self.time_limit_s { map.serialize_entry("time_limit_s", value)?; }

        Ok(())
    }
}
written!(crate::v1::RollOutRequest);

impl Fields for crate::v1::KnotTimes {
    const NAME: &'static str = "KnotTimes";
    const FIELDS: &'static [&'static str] = &["at_s", "period_s"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { only_one(&mut self.times, tensor(map, Dtype::Float32)?.map(crate::v1::knot_times::Times::AtS))?; }
1 => { only_one(&mut self.times, map.next_value::<Option<_>>()?.map(crate::v1::knot_times::Times::PeriodS))?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        if let Some(crate::v1::knot_times::Times::AtS(value)) = &self.times { write_tensor(map, "at_s", Some(value), tensors)?; }
if let Some(crate::v1::knot_times::Times::PeriodS(value)) = &self.times { map.serialize_entry("period_s", value)?; }

        Ok(())
    }
}
written!(crate::v1::KnotTimes);

impl Fields for crate::v1::Ensemble {
    const NAME: &'static str = "Ensemble";
    const FIELDS: &'static [&'static str] = &["members", "statistic", "share"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.members = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.statistic = word::<crate::v1::ensemble::Statistic, A>(map)?; }
2 => { self.share = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("members", &self.members)?;
write_word::<crate::v1::ensemble::Statistic, M>(map, "statistic", self.statistic)?;
map.serialize_entry("share", &self.share)?;

        Ok(())
    }
}
written!(crate::v1::Ensemble);

impl Words for crate::v1::ensemble::Statistic {
    const KNOWN: &'static [&'static str] = &["MEAN", "WORST", "CVAR", "MEAN_PREDICTION"];
    fn number(word: &str) -> Option<i32> {
        Self::from_str_name(word).map(Into::into)
    }
    fn word(number: i32) -> Option<&'static str> {
        Self::try_from(number).ok().map(|value| value.as_str_name())
    }
}
word_written!(crate::v1::ensemble::Statistic);

impl Fields for crate::v1::GradientOptions {
    const NAME: &'static str = "GradientOptions";
    const FIELDS: &'static [&'static str] = &["reach_frames", "smoothing_m"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.reach_frames = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.smoothing_m = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("reach_frames", &self.reach_frames)?;
map.serialize_entry("smoothing_m", &self.smoothing_m)?;

        Ok(())
    }
}
written!(crate::v1::GradientOptions);

impl Fields for crate::v1::Plausibility {
    const NAME: &'static str = "Plausibility";
    const FIELDS: &'static [&'static str] = &["start_gap_m", "control_speed_m_s", "strain", "refuse", "control_depth_m", "grasp_force_n"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.start_gap_m = map.next_value()?; }
1 => { self.control_speed_m_s = map.next_value()?; }
2 => { self.strain = map.next_value()?; }
3 => { self.refuse = map.next_value::<Option<_>>()?.unwrap_or_default(); }
4 => { self.control_depth_m = map.next_value()?; }
5 => { self.grasp_force_n = map.next_value()?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        if let Some(value) = &self.start_gap_m { map.serialize_entry("start_gap_m", value)?; }
if let Some(value) = &self.control_speed_m_s { map.serialize_entry("control_speed_m_s", value)?; }
if let Some(value) = &self.strain { map.serialize_entry("strain", value)?; }
map.serialize_entry("refuse", &self.refuse)?;
if let Some(value) = &self.control_depth_m { map.serialize_entry("control_depth_m", value)?; }
if let Some(value) = &self.grasp_force_n { map.serialize_entry("grasp_force_n", value)?; }

        Ok(())
    }
}
written!(crate::v1::Plausibility);

impl Fields for crate::v1::ControlTrajectories {
    const NAME: &'static str = "ControlTrajectories";
    const FIELDS: &'static [&'static str] = &["positions", "interpolation"];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::ControlTrajectories);

impl Fields for crate::v1::GripperPoses {
    const NAME: &'static str = "GripperPoses";
    const FIELDS: &'static [&'static str] = &["poses", "gripper_of_control", "interpolation"];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::GripperPoses);

impl Fields for crate::v1::InitialState {
    const NAME: &'static str = "InitialState";
    const FIELDS: &'static [&'static str] = &["rest", "capture_frame", "given", "settled", "session"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { only_one(&mut self.state, message(map)?.map(crate::v1::initial_state::State::Rest))?; }
1 => { only_one(&mut self.state, message(map)?.map(crate::v1::initial_state::State::CaptureFrame))?; }
2 => { only_one(&mut self.state, message(map)?.map(crate::v1::initial_state::State::Given))?; }
3 => { only_one(&mut self.state, message(map)?.map(crate::v1::initial_state::State::Settled))?; }
4 => { only_one(&mut self.state, message(map)?.map(crate::v1::initial_state::State::Session))?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        if let Some(crate::v1::initial_state::State::Rest(value)) = &self.state { write_message(map, "rest", Some(value), tensors)?; }
if let Some(crate::v1::initial_state::State::CaptureFrame(value)) = &self.state { write_message(map, "capture_frame", Some(value), tensors)?; }
if let Some(crate::v1::initial_state::State::Given(value)) = &self.state { write_message(map, "given", Some(value), tensors)?; }
if let Some(crate::v1::initial_state::State::Settled(value)) = &self.state { write_message(map, "settled", Some(value), tensors)?; }
if let Some(crate::v1::initial_state::State::Session(value)) = &self.state { write_message(map, "session", Some(value), tensors)?; }

        Ok(())
    }
}
written!(crate::v1::InitialState);

impl Fields for crate::v1::initial_state::Rest {
    const NAME: &'static str = "Rest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::initial_state::Rest);

impl Fields for crate::v1::initial_state::Settled {
    const NAME: &'static str = "Settled";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::initial_state::Settled);

impl Fields for crate::v1::initial_state::SessionSlots {
    const NAME: &'static str = "SessionSlots";
    const FIELDS: &'static [&'static str] = &["session", "slots"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.session = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.slots = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("session", &self.session)?;
map.serialize_entry("slots", &self.slots)?;

        Ok(())
    }
}
written!(crate::v1::initial_state::SessionSlots);

impl Fields for crate::v1::initial_state::CaptureFrame {
    const NAME: &'static str = "CaptureFrame";
    const FIELDS: &'static [&'static str] = &["capture", "sequence", "frame"];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::initial_state::CaptureFrame);

impl Fields for crate::v1::initial_state::GivenState {
    const NAME: &'static str = "GivenState";
    const FIELDS: &'static [&'static str] = &["positions", "velocities", "twists", "controls", "grasping", "commanded_controls"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.positions = tensor(map, Dtype::Float32)?; }
1 => { self.velocities = tensor(map, Dtype::Float32)?; }
2 => { self.twists = tensor(map, Dtype::Float32)?; }
3 => { self.controls = tensor(map, Dtype::Float32)?; }
4 => { self.grasping = message(map)?; }
5 => { self.commanded_controls = tensor(map, Dtype::Float32)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_tensor(map, "positions", self.positions.as_ref(), tensors)?;
write_tensor(map, "velocities", self.velocities.as_ref(), tensors)?;
write_tensor(map, "twists", self.twists.as_ref(), tensors)?;
write_tensor(map, "controls", self.controls.as_ref(), tensors)?;
write_message(map, "grasping", self.grasping.as_ref(), tensors)?;
write_tensor(map, "commanded_controls", self.commanded_controls.as_ref(), tensors)?;

        Ok(())
    }
}
written!(crate::v1::initial_state::GivenState);

impl Fields for crate::v1::Cost {
    const NAME: &'static str = "Cost";
    const FIELDS: &'static [&'static str] = &["name", "weight", "when", "target_cloud", "keypoints", "smoothness", "strain", "force", "height", "within", "clearance", "control_path", "control_speed", "order", "winding", "coverage", "temperature", "success_at_most"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.weight = map.next_value()?; }
2 => { self.when = word::<crate::v1::cost::When, A>(map)?; }
3 => { only_one(&mut self.kind, message(map)?.map(crate::v1::cost::Kind::TargetCloud))?; }
4 => { only_one(&mut self.kind, message(map)?.map(crate::v1::cost::Kind::Keypoints))?; }
5 => { only_one(&mut self.kind, message(map)?.map(crate::v1::cost::Kind::Smoothness))?; }
6 => { only_one(&mut self.kind, message(map)?.map(crate::v1::cost::Kind::Strain))?; }
7 => { only_one(&mut self.kind, message(map)?.map(crate::v1::cost::Kind::Force))?; }
8 => { only_one(&mut self.kind, message(map)?.map(crate::v1::cost::Kind::Height))?; }
9 => { only_one(&mut self.kind, message(map)?.map(crate::v1::cost::Kind::Within))?; }
10 => { only_one(&mut self.kind, message(map)?.map(crate::v1::cost::Kind::Clearance))?; }
11 => { only_one(&mut self.kind, message(map)?.map(crate::v1::cost::Kind::ControlPath))?; }
12 => { only_one(&mut self.kind, message(map)?.map(crate::v1::cost::Kind::ControlSpeed))?; }
13 => { only_one(&mut self.kind, message(map)?.map(crate::v1::cost::Kind::Order))?; }
14 => { only_one(&mut self.kind, message(map)?.map(crate::v1::cost::Kind::Winding))?; }
15 => { only_one(&mut self.kind, message(map)?.map(crate::v1::cost::Kind::Coverage))?; }
16 => { self.temperature = map.next_value::<Option<_>>()?.unwrap_or_default(); }
17 => { self.success_at_most = map.next_value()?; }

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
if let Some(crate::v1::cost::Kind::Strain(value)) = &self.kind { write_message(map, "strain", Some(value), tensors)?; }
if let Some(crate::v1::cost::Kind::Force(value)) = &self.kind { write_message(map, "force", Some(value), tensors)?; }
if let Some(crate::v1::cost::Kind::Height(value)) = &self.kind { write_message(map, "height", Some(value), tensors)?; }
if let Some(crate::v1::cost::Kind::Within(value)) = &self.kind { write_message(map, "within", Some(value), tensors)?; }
if let Some(crate::v1::cost::Kind::Clearance(value)) = &self.kind { write_message(map, "clearance", Some(value), tensors)?; }
if let Some(crate::v1::cost::Kind::ControlPath(value)) = &self.kind { write_message(map, "control_path", Some(value), tensors)?; }
if let Some(crate::v1::cost::Kind::ControlSpeed(value)) = &self.kind { write_message(map, "control_speed", Some(value), tensors)?; }
if let Some(crate::v1::cost::Kind::Order(value)) = &self.kind { write_message(map, "order", Some(value), tensors)?; }
if let Some(crate::v1::cost::Kind::Winding(value)) = &self.kind { write_message(map, "winding", Some(value), tensors)?; }
if let Some(crate::v1::cost::Kind::Coverage(value)) = &self.kind { write_message(map, "coverage", Some(value), tensors)?; }
map.serialize_entry("temperature", &self.temperature)?;
if let Some(value) = &self.success_at_most { map.serialize_entry("success_at_most", value)?; }

        Ok(())
    }
}
written!(crate::v1::Cost);

impl Fields for crate::v1::cost::TargetCloud {
    const NAME: &'static str = "TargetCloud";
    const FIELDS: &'static [&'static str] = &["points", "point_set"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.points = tensor(map, Dtype::Float32)?; }
1 => { self.point_set = word::<crate::v1::PointSet, A>(map)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_tensor(map, "points", self.points.as_ref(), tensors)?;
write_word::<crate::v1::PointSet, M>(map, "point_set", self.point_set)?;

        Ok(())
    }
}
written!(crate::v1::cost::TargetCloud);

impl Fields for crate::v1::cost::Keypoints {
    const NAME: &'static str = "Keypoints";
    const FIELDS: &'static [&'static str] = &["nodes", "targets", "squared", "skin_points"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.nodes = tensor(map, Dtype::Uint32)?; }
1 => { self.targets = tensor(map, Dtype::Float32)?; }
2 => { self.squared = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.skin_points = tensor(map, Dtype::Float32)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_tensor(map, "nodes", self.nodes.as_ref(), tensors)?;
write_tensor(map, "targets", self.targets.as_ref(), tensors)?;
map.serialize_entry("squared", &self.squared)?;
write_tensor(map, "skin_points", self.skin_points.as_ref(), tensors)?;

        Ok(())
    }
}
written!(crate::v1::cost::Keypoints);

impl Fields for crate::v1::cost::Smoothness {
    const NAME: &'static str = "Smoothness";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::cost::Smoothness);

impl Fields for crate::v1::cost::Strain {
    const NAME: &'static str = "Strain";
    const FIELDS: &'static [&'static str] = &["limit"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.limit = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("limit", &self.limit)?;

        Ok(())
    }
}
written!(crate::v1::cost::Strain);

impl Fields for crate::v1::cost::Force {
    const NAME: &'static str = "Force";
    const FIELDS: &'static [&'static str] = &["controls", "control", "grasp", "ground", "collider", "limit_n"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { only_one(&mut self.by, message(map)?.map(crate::v1::cost::force::By::Controls))?; }
1 => { only_one(&mut self.by, map.next_value::<Option<_>>()?.map(crate::v1::cost::force::By::Control))?; }
2 => { only_one(&mut self.by, map.next_value::<Option<_>>()?.map(crate::v1::cost::force::By::Grasp))?; }
3 => { only_one(&mut self.by, message(map)?.map(crate::v1::cost::force::By::Ground))?; }
4 => { only_one(&mut self.by, map.next_value::<Option<_>>()?.map(crate::v1::cost::force::By::Collider))?; }
5 => { self.limit_n = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        if let Some(crate::v1::cost::force::By::Controls(value)) = &self.by { write_message(map, "controls", Some(value), tensors)?; }
if let Some(crate::v1::cost::force::By::Control(value)) = &self.by { map.serialize_entry("control", value)?; }
if let Some(crate::v1::cost::force::By::Grasp(value)) = &self.by { map.serialize_entry("grasp", value)?; }
if let Some(crate::v1::cost::force::By::Ground(value)) = &self.by { write_message(map, "ground", Some(value), tensors)?; }
if let Some(crate::v1::cost::force::By::Collider(value)) = &self.by { map.serialize_entry("collider", value)?; }
map.serialize_entry("limit_n", &self.limit_n)?;

        Ok(())
    }
}
written!(crate::v1::cost::Force);

impl Fields for crate::v1::cost::force::All {
    const NAME: &'static str = "All";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::cost::force::All);

impl Fields for crate::v1::cost::Height {
    const NAME: &'static str = "Height";
    const FIELDS: &'static [&'static str] = &["plane", "nodes"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.plane = message(map)?; }
1 => { self.nodes = tensor(map, Dtype::Uint32)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_message(map, "plane", self.plane.as_ref(), tensors)?;
write_tensor(map, "nodes", self.nodes.as_ref(), tensors)?;

        Ok(())
    }
}
written!(crate::v1::cost::Height);

impl Fields for crate::v1::cost::Within {
    const NAME: &'static str = "Within";
    const FIELDS: &'static [&'static str] = &["cuboid", "nodes"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.cuboid = message(map)?; }
1 => { self.nodes = tensor(map, Dtype::Uint32)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_message(map, "cuboid", self.cuboid.as_ref(), tensors)?;
write_tensor(map, "nodes", self.nodes.as_ref(), tensors)?;

        Ok(())
    }
}
written!(crate::v1::cost::Within);

impl Fields for crate::v1::cost::Clearance {
    const NAME: &'static str = "Clearance";
    const FIELDS: &'static [&'static str] = &["collider", "margin_m"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.collider = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.margin_m = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("collider", &self.collider)?;
map.serialize_entry("margin_m", &self.margin_m)?;

        Ok(())
    }
}
written!(crate::v1::cost::Clearance);

impl Fields for crate::v1::cost::ControlPath {
    const NAME: &'static str = "ControlPath";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::cost::ControlPath);

impl Fields for crate::v1::cost::ControlSpeed {
    const NAME: &'static str = "ControlSpeed";
    const FIELDS: &'static [&'static str] = &["limit_m_s"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.limit_m_s = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("limit_m_s", &self.limit_m_s)?;

        Ok(())
    }
}
written!(crate::v1::cost::ControlSpeed);

impl Fields for crate::v1::cost::Order {
    const NAME: &'static str = "Order";
    const FIELDS: &'static [&'static str] = &["nodes", "direction", "gap_m", "skin_points"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.nodes = tensor(map, Dtype::Uint32)?; }
1 => { self.direction = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.gap_m = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.skin_points = tensor(map, Dtype::Float32)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_tensor(map, "nodes", self.nodes.as_ref(), tensors)?;
map.serialize_entry("direction", &self.direction)?;
map.serialize_entry("gap_m", &self.gap_m)?;
write_tensor(map, "skin_points", self.skin_points.as_ref(), tensors)?;

        Ok(())
    }
}
written!(crate::v1::cost::Order);

impl Fields for crate::v1::cost::Winding {
    const NAME: &'static str = "Winding";
    const FIELDS: &'static [&'static str] = &["nodes", "axis", "collider", "turns", "skin_points"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.nodes = tensor(map, Dtype::Uint32)?; }
1 => { only_one(&mut self.around, message(map)?.map(crate::v1::cost::winding::Around::Axis))?; }
2 => { only_one(&mut self.around, map.next_value::<Option<_>>()?.map(crate::v1::cost::winding::Around::Collider))?; }
3 => { self.turns = map.next_value::<Option<_>>()?.unwrap_or_default(); }
4 => { self.skin_points = tensor(map, Dtype::Float32)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_tensor(map, "nodes", self.nodes.as_ref(), tensors)?;
if let Some(crate::v1::cost::winding::Around::Axis(value)) = &self.around { write_message(map, "axis", Some(value), tensors)?; }
if let Some(crate::v1::cost::winding::Around::Collider(value)) = &self.around { map.serialize_entry("collider", value)?; }
map.serialize_entry("turns", &self.turns)?;
write_tensor(map, "skin_points", self.skin_points.as_ref(), tensors)?;

        Ok(())
    }
}
written!(crate::v1::cost::Winding);

impl Fields for crate::v1::cost::winding::Axis {
    const NAME: &'static str = "Axis";
    const FIELDS: &'static [&'static str] = &["point", "direction"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.point = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.direction = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("point", &self.point)?;
map.serialize_entry("direction", &self.direction)?;

        Ok(())
    }
}
written!(crate::v1::cost::winding::Axis);

impl Fields for crate::v1::cost::Coverage {
    const NAME: &'static str = "Coverage";
    const FIELDS: &'static [&'static str] = &["points", "reach_m", "point_set"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.points = tensor(map, Dtype::Float32)?; }
1 => { self.reach_m = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.point_set = word::<crate::v1::PointSet, A>(map)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_tensor(map, "points", self.points.as_ref(), tensors)?;
map.serialize_entry("reach_m", &self.reach_m)?;
write_word::<crate::v1::PointSet, M>(map, "point_set", self.point_set)?;

        Ok(())
    }
}
written!(crate::v1::cost::Coverage);

impl Words for crate::v1::cost::When {
    const KNOWN: &'static [&'static str] = &["LAST_FRAME", "EVERY_FRAME", "SOFT_MIN"];
    fn number(word: &str) -> Option<i32> {
        Self::from_str_name(word).map(Into::into)
    }
    fn word(number: i32) -> Option<&'static str> {
        Self::try_from(number).ok().map(|value| value.as_str_name())
    }
}
word_written!(crate::v1::cost::When);

impl Fields for crate::v1::Returns {
    const NAME: &'static str = "Returns";
    const FIELDS: &'static [&'static str] = &["every_frames", "nodes", "encoding", "best", "final_state", "diagnostics", "control_gradients", "action_gradients", "initial_gradients", "gradient_norms", "velocities", "forces", "frame_costs", "controls", "part_frames", "point_set", "skin_points", "spread"];
    const REQUIRED: &'static [&'static str] = &[];
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
7 => { self.action_gradients = map.next_value::<Option<_>>()?.unwrap_or_default(); }
8 => { self.initial_gradients = map.next_value::<Option<_>>()?.unwrap_or_default(); }
9 => { self.gradient_norms = map.next_value::<Option<_>>()?.unwrap_or_default(); }
10 => { self.velocities = map.next_value::<Option<_>>()?.unwrap_or_default(); }
11 => { self.forces = map.next_value::<Option<_>>()?.unwrap_or_default(); }
12 => { self.frame_costs = map.next_value::<Option<_>>()?.unwrap_or_default(); }
13 => { self.controls = map.next_value::<Option<_>>()?.unwrap_or_default(); }
14 => { self.part_frames = map.next_value::<Option<_>>()?.unwrap_or_default(); }
15 => { self.point_set = word::<crate::v1::PointSet, A>(map)?; }
16 => { self.skin_points = tensor(map, Dtype::Float32)?; }
17 => { self.spread = map.next_value::<Option<_>>()?.unwrap_or_default(); }

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
map.serialize_entry("action_gradients", &self.action_gradients)?;
map.serialize_entry("initial_gradients", &self.initial_gradients)?;
map.serialize_entry("gradient_norms", &self.gradient_norms)?;
map.serialize_entry("velocities", &self.velocities)?;
map.serialize_entry("forces", &self.forces)?;
map.serialize_entry("frame_costs", &self.frame_costs)?;
map.serialize_entry("controls", &self.controls)?;
map.serialize_entry("part_frames", &self.part_frames)?;
write_word::<crate::v1::PointSet, M>(map, "point_set", self.point_set)?;
write_tensor(map, "skin_points", self.skin_points.as_ref(), tensors)?;
map.serialize_entry("spread", &self.spread)?;

        Ok(())
    }
}
written!(crate::v1::Returns);

impl Words for crate::v1::returns::Encoding {
    const KNOWN: &'static [&'static str] = &["FLOAT32", "INT16"];
    fn number(word: &str) -> Option<i32> {
        Self::from_str_name(word).map(Into::into)
    }
    fn word(number: i32) -> Option<&'static str> {
        Self::try_from(number).ok().map(|value| value.as_str_name())
    }
}
word_written!(crate::v1::returns::Encoding);

impl Fields for crate::v1::RollOutResponse {
    const NAME: &'static str = "RollOutResponse";
    const FIELDS: &'static [&'static str] = &["first_instance", "costs", "cost_names", "cost_terms", "instances", "frames", "positions", "final_positions", "final_velocities", "control_gradients", "diagnostics", "diverged", "timing", "worker", "fidelity", "substeps", "deviation", "final_twists", "final_controls", "final_grasping", "final_commanded_controls", "action_gradients", "initial_position_gradients", "initial_velocity_gradients", "gradient_norms", "gradient_exploded", "velocities", "forces", "frame_costs", "controls", "member_costs", "implausible", "mass_kg", "window", "unfinished", "spread", "successes"];
    const REQUIRED: &'static [&'static str] = &[];
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
18 => { self.final_controls = tensor(map, Dtype::Float32)?; }
19 => { self.final_grasping = message(map)?; }
20 => { self.final_commanded_controls = tensor(map, Dtype::Float32)?; }
21 => { self.action_gradients = tensor(map, Dtype::Float32)?; }
22 => { self.initial_position_gradients = tensor(map, Dtype::Float32)?; }
23 => { self.initial_velocity_gradients = tensor(map, Dtype::Float32)?; }
24 => { self.gradient_norms = tensor(map, Dtype::Float32)?; }
25 => { self.gradient_exploded = tensor(map, Dtype::Uint32)?; }
26 => { self.velocities = tensor(map, Dtype::Float32)?; }
27 => { self.forces = message(map)?; }
28 => { self.frame_costs = tensor(map, Dtype::Float32)?; }
29 => { self.controls = tensor(map, Dtype::Float32)?; }
30 => { self.member_costs = tensor(map, Dtype::Float32)?; }
31 => { self.implausible = messages(map)?; }
32 => { self.mass_kg = map.next_value()?; }
33 => { self.window = message(map)?; }
34 => { self.unfinished = tensor(map, Dtype::Float32)?; }
35 => { self.spread = tensor(map, Dtype::Float32)?; }
36 => { self.successes = tensor(map, Dtype::Float32)?; }

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
write_tensor(map, "final_controls", self.final_controls.as_ref(), tensors)?;
write_message(map, "final_grasping", self.final_grasping.as_ref(), tensors)?;
write_tensor(map, "final_commanded_controls", self.final_commanded_controls.as_ref(), tensors)?;
write_tensor(map, "action_gradients", self.action_gradients.as_ref(), tensors)?;
write_tensor(map, "initial_position_gradients", self.initial_position_gradients.as_ref(), tensors)?;
write_tensor(map, "initial_velocity_gradients", self.initial_velocity_gradients.as_ref(), tensors)?;
write_tensor(map, "gradient_norms", self.gradient_norms.as_ref(), tensors)?;
write_tensor(map, "gradient_exploded", self.gradient_exploded.as_ref(), tensors)?;
write_tensor(map, "velocities", self.velocities.as_ref(), tensors)?;
write_message(map, "forces", self.forces.as_ref(), tensors)?;
write_tensor(map, "frame_costs", self.frame_costs.as_ref(), tensors)?;
write_tensor(map, "controls", self.controls.as_ref(), tensors)?;
write_tensor(map, "member_costs", self.member_costs.as_ref(), tensors)?;
write_messages(map, "implausible", &self.implausible, tensors)?;
if let Some(value) = &self.mass_kg { map.serialize_entry("mass_kg", value)?; }
write_message(map, "window", self.window.as_ref(), tensors)?;
write_tensor(map, "unfinished", self.unfinished.as_ref(), tensors)?;
write_tensor(map, "spread", self.spread.as_ref(), tensors)?;
write_tensor(map, "successes", self.successes.as_ref(), tensors)?;

        Ok(())
    }
}
written!(crate::v1::RollOutResponse);

impl Fields for crate::v1::roll_out_response::Window {
    const NAME: &'static str = "Window";
    const FIELDS: &'static [&'static str] = &["first_frame", "last_frame"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.first_frame = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.last_frame = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("first_frame", &self.first_frame)?;
map.serialize_entry("last_frame", &self.last_frame)?;

        Ok(())
    }
}
written!(crate::v1::roll_out_response::Window);

impl Fields for crate::v1::roll_out_response::Forces {
    const NAME: &'static str = "Forces";
    const FIELDS: &'static [&'static str] = &["controls", "grasps", "ground", "colliders"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.controls = tensor(map, Dtype::Float32)?; }
1 => { self.grasps = tensor(map, Dtype::Float32)?; }
2 => { self.ground = tensor(map, Dtype::Float32)?; }
3 => { self.colliders = tensor(map, Dtype::Float32)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_tensor(map, "controls", self.controls.as_ref(), tensors)?;
write_tensor(map, "grasps", self.grasps.as_ref(), tensors)?;
write_tensor(map, "ground", self.ground.as_ref(), tensors)?;
write_tensor(map, "colliders", self.colliders.as_ref(), tensors)?;

        Ok(())
    }
}
written!(crate::v1::roll_out_response::Forces);

impl Fields for crate::v1::roll_out_response::Implausible {
    const NAME: &'static str = "Implausible";
    const FIELDS: &'static [&'static str] = &["instance", "reason", "found", "limit", "frame", "grasp"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.instance = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.reason = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.found = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.limit = map.next_value::<Option<_>>()?.unwrap_or_default(); }
4 => { self.frame = map.next_value::<Option<_>>()?.unwrap_or_default(); }
5 => { self.grasp = map.next_value()?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("instance", &self.instance)?;
map.serialize_entry("reason", &self.reason)?;
map.serialize_entry("found", &self.found)?;
map.serialize_entry("limit", &self.limit)?;
map.serialize_entry("frame", &self.frame)?;
if let Some(value) = &self.grasp { map.serialize_entry("grasp", value)?; }

        Ok(())
    }
}
written!(crate::v1::roll_out_response::Implausible);

impl Fields for crate::v1::roll_out_response::Diagnostics {
    const NAME: &'static str = "Diagnostics";
    const FIELDS: &'static [&'static str] = &["max_strain", "max_speed_m_s", "kinetic_energy", "elastic_energy", "ground_contacts", "max_control_strain", "control_depth_m", "stopped_hand_m"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.max_strain = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.max_speed_m_s = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.kinetic_energy = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.elastic_energy = map.next_value::<Option<_>>()?.unwrap_or_default(); }
4 => { self.ground_contacts = map.next_value::<Option<_>>()?.unwrap_or_default(); }
5 => { self.max_control_strain = map.next_value::<Option<_>>()?.unwrap_or_default(); }
6 => { self.control_depth_m = map.next_value::<Option<_>>()?.unwrap_or_default(); }
7 => { self.stopped_hand_m = map.next_value::<Option<_>>()?.unwrap_or_default(); }

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
map.serialize_entry("max_control_strain", &self.max_control_strain)?;
map.serialize_entry("control_depth_m", &self.control_depth_m)?;
map.serialize_entry("stopped_hand_m", &self.stopped_hand_m)?;

        Ok(())
    }
}
written!(crate::v1::roll_out_response::Diagnostics);

impl Fields for crate::v1::roll_out_response::Divergence {
    const NAME: &'static str = "Divergence";
    const FIELDS: &'static [&'static str] = &["instance", "frame", "node"];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::roll_out_response::Divergence);

impl Fields for crate::v1::roll_out_response::Timing {
    const NAME: &'static str = "Timing";
    const FIELDS: &'static [&'static str] = &["queue_s", "compute_s"];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::roll_out_response::Timing);

impl Fields for crate::v1::roll_out_response::Deviation {
    const NAME: &'static str = "Deviation";
    const FIELDS: &'static [&'static str] = &["mean_m", "max_m", "mean_travel_m", "frames"];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::roll_out_response::Deviation);

impl Words for crate::v1::Fidelity {
    const KNOWN: &'static [&'static str] = &["EXACT", "FAST", "PLANNER"];
    fn number(word: &str) -> Option<i32> {
        Self::from_str_name(word).map(Into::into)
    }
    fn word(number: i32) -> Option<&'static str> {
        Self::try_from(number).ok().map(|value| value.as_str_name())
    }
}
word_written!(crate::v1::Fidelity);

impl Words for crate::v1::PointSet {
    const KNOWN: &'static [&'static str] = &["NODES", "SKIN"];
    fn number(word: &str) -> Option<i32> {
        Self::from_str_name(word).map(Into::into)
    }
    fn word(number: i32) -> Option<&'static str> {
        Self::try_from(number).ok().map(|value| value.as_str_name())
    }
}
word_written!(crate::v1::PointSet);

impl Words for crate::v1::Interpolation {
    const KNOWN: &'static [&'static str] = &["LINEAR", "CUBIC", "ZERO"];
    fn number(word: &str) -> Option<i32> {
        Self::from_str_name(word).map(Into::into)
    }
    fn word(number: i32) -> Option<&'static str> {
        Self::try_from(number).ok().map(|value| value.as_str_name())
    }
}
word_written!(crate::v1::Interpolation);

impl Fields for crate::v1::PlanRequest {
    const NAME: &'static str = "PlanRequest";
    const FIELDS: &'static [&'static str] = &["rollout", "space", "method", "samples", "iterations", "sigma", "correlation", "finest", "bounds", "seed", "deadline_s", "shift_frames", "grasp_search"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.rollout = message(map)?; }
1 => { self.space = message(map)?; }
2 => { self.method = message(map)?; }
3 => { self.samples = map.next_value::<Option<_>>()?.unwrap_or_default(); }
4 => { self.iterations = map.next_value::<Option<_>>()?.unwrap_or_default(); }
5 => { self.sigma = tensor(map, Dtype::Float32)?; }
6 => { self.correlation = map.next_value::<Option<_>>()?.unwrap_or_default(); }
7 => { self.finest = map.next_value()?; }
8 => { self.bounds = message(map)?; }
9 => { self.seed = map.next_value::<Option<_>>()?.unwrap_or_default(); }
10 => { self.deadline_s = map.next_value::<Option<_>>()?.unwrap_or_default(); }
11 => { self.shift_frames = map.next_value::<Option<_>>()?.unwrap_or_default(); }
12 => { self.grasp_search = message(map)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_message(map, "rollout", self.rollout.as_ref(), tensors)?;
write_message(map, "space", self.space.as_ref(), tensors)?;
write_message(map, "method", self.method.as_ref(), tensors)?;
map.serialize_entry("samples", &self.samples)?;
map.serialize_entry("iterations", &self.iterations)?;
write_tensor(map, "sigma", self.sigma.as_ref(), tensors)?;
map.serialize_entry("correlation", &self.correlation)?;
if let Some(value) = &self.finest { map.serialize_entry("finest", value)?; }
write_message(map, "bounds", self.bounds.as_ref(), tensors)?;
map.serialize_entry("seed", &self.seed)?;
map.serialize_entry("deadline_s", &self.deadline_s)?;
map.serialize_entry("shift_frames", &self.shift_frames)?;
write_message(map, "grasp_search", self.grasp_search.as_ref(), tensors)?;

        Ok(())
    }
}
written!(crate::v1::PlanRequest);

impl Fields for crate::v1::GraspSearch {
    const NAME: &'static str = "GraspSearch";
    const FIELDS: &'static [&'static str] = &["poses", "grippers"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.poses = tensor(map, Dtype::Float32)?; }
1 => { self.grippers = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_tensor(map, "poses", self.poses.as_ref(), tensors)?;
map.serialize_entry("grippers", &self.grippers)?;

        Ok(())
    }
}
written!(crate::v1::GraspSearch);

impl Fields for crate::v1::ActionSpace {
    const NAME: &'static str = "ActionSpace";
    const FIELDS: &'static [&'static str] = &["coordinates", "group_of_control", "start"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.coordinates = word::<crate::v1::action_space::Coordinates, A>(map)?; }
1 => { self.group_of_control = tensor(map, Dtype::Uint32)?; }
2 => { self.start = tensor(map, Dtype::Float32)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_word::<crate::v1::action_space::Coordinates, M>(map, "coordinates", self.coordinates)?;
write_tensor(map, "group_of_control", self.group_of_control.as_ref(), tensors)?;
write_tensor(map, "start", self.start.as_ref(), tensors)?;

        Ok(())
    }
}
written!(crate::v1::ActionSpace);

impl Words for crate::v1::action_space::Coordinates {
    const KNOWN: &'static [&'static str] = &["TOGETHER", "PER_GROUP", "POINTS", "TRANSLATION", "RIGID"];
    fn number(word: &str) -> Option<i32> {
        Self::from_str_name(word).map(Into::into)
    }
    fn word(number: i32) -> Option<&'static str> {
        Self::try_from(number).ok().map(|value| value.as_str_name())
    }
}
word_written!(crate::v1::action_space::Coordinates);

impl Fields for crate::v1::PlanMethod {
    const NAME: &'static str = "PlanMethod";
    const FIELDS: &'static [&'static str] = &["mppi", "cem", "predictive_sampling", "gradient"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { only_one(&mut self.method, message(map)?.map(crate::v1::plan_method::Method::Mppi))?; }
1 => { only_one(&mut self.method, message(map)?.map(crate::v1::plan_method::Method::Cem))?; }
2 => { only_one(&mut self.method, message(map)?.map(crate::v1::plan_method::Method::PredictiveSampling))?; }
3 => { only_one(&mut self.method, message(map)?.map(crate::v1::plan_method::Method::Gradient))?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        if let Some(crate::v1::plan_method::Method::Mppi(value)) = &self.method { write_message(map, "mppi", Some(value), tensors)?; }
if let Some(crate::v1::plan_method::Method::Cem(value)) = &self.method { write_message(map, "cem", Some(value), tensors)?; }
if let Some(crate::v1::plan_method::Method::PredictiveSampling(value)) = &self.method { write_message(map, "predictive_sampling", Some(value), tensors)?; }
if let Some(crate::v1::plan_method::Method::Gradient(value)) = &self.method { write_message(map, "gradient", Some(value), tensors)?; }

        Ok(())
    }
}
written!(crate::v1::PlanMethod);

impl Fields for crate::v1::plan_method::Mppi {
    const NAME: &'static str = "Mppi";
    const FIELDS: &'static [&'static str] = &["temperature"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.temperature = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("temperature", &self.temperature)?;

        Ok(())
    }
}
written!(crate::v1::plan_method::Mppi);

impl Fields for crate::v1::plan_method::Cem {
    const NAME: &'static str = "Cem";
    const FIELDS: &'static [&'static str] = &["elites", "memory", "smallest"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.elites = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.memory = map.next_value()?; }
2 => { self.smallest = map.next_value()?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("elites", &self.elites)?;
if let Some(value) = &self.memory { map.serialize_entry("memory", value)?; }
if let Some(value) = &self.smallest { map.serialize_entry("smallest", value)?; }

        Ok(())
    }
}
written!(crate::v1::plan_method::Cem);

impl Fields for crate::v1::plan_method::PredictiveSampling {
    const NAME: &'static str = "PredictiveSampling";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::plan_method::PredictiveSampling);

impl Fields for crate::v1::plan_method::Gradient {
    const NAME: &'static str = "Gradient";
    const FIELDS: &'static [&'static str] = &["rate"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.rate = tensor(map, Dtype::Float32)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_tensor(map, "rate", self.rate.as_ref(), tensors)?;

        Ok(())
    }
}
written!(crate::v1::plan_method::Gradient);

impl Fields for crate::v1::PlanBounds {
    const NAME: &'static str = "PlanBounds";
    const FIELDS: &'static [&'static str] = &["low", "high", "speed"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.low = tensor(map, Dtype::Float32)?; }
1 => { self.high = tensor(map, Dtype::Float32)?; }
2 => { self.speed = tensor(map, Dtype::Float32)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_tensor(map, "low", self.low.as_ref(), tensors)?;
write_tensor(map, "high", self.high.as_ref(), tensors)?;
write_tensor(map, "speed", self.speed.as_ref(), tensors)?;

        Ok(())
    }
}
written!(crate::v1::PlanBounds);

impl Fields for crate::v1::PlanUpdate {
    const NAME: &'static str = "PlanUpdate";
    const FIELDS: &'static [&'static str] = &["knots", "coordinates", "cost", "cost_names", "cost_terms", "origin", "nominal_cost", "iterations", "simulated", "diverged", "stopped_by_deadline", "time_s", "last", "rollout", "strain", "strain_limit", "overstrained", "grasp", "grasp_costs", "grasp_force_n", "grasp_force_limit_n"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.knots = tensor(map, Dtype::Float32)?; }
1 => { self.coordinates = tensor(map, Dtype::Float32)?; }
2 => { self.cost = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.cost_names = map.next_value::<Option<_>>()?.unwrap_or_default(); }
4 => { self.cost_terms = tensor(map, Dtype::Float32)?; }
5 => { self.origin = word::<crate::v1::plan_update::Origin, A>(map)?; }
6 => { self.nominal_cost = map.next_value::<Option<_>>()?.unwrap_or_default(); }
7 => { self.iterations = map.next_value::<Option<_>>()?.unwrap_or_default(); }
8 => { self.simulated = map.next_value::<Option<_>>()?.unwrap_or_default(); }
9 => { self.diverged = map.next_value::<Option<_>>()?.unwrap_or_default(); }
10 => { self.stopped_by_deadline = map.next_value::<Option<_>>()?.unwrap_or_default(); }
11 => { self.time_s = map.next_value::<Option<_>>()?.unwrap_or_default(); }
12 => { self.last = map.next_value::<Option<_>>()?.unwrap_or_default(); }
13 => { self.rollout = message(map)?; }
14 => { self.strain = map.next_value::<Option<_>>()?.unwrap_or_default(); }
15 => { self.strain_limit = map.next_value::<Option<_>>()?.unwrap_or_default(); }
16 => { self.overstrained = map.next_value::<Option<_>>()?.unwrap_or_default(); }
17 => { self.grasp = map.next_value()?; }
18 => { self.grasp_costs = tensor(map, Dtype::Float32)?; }
19 => { self.grasp_force_n = map.next_value()?; }
20 => { self.grasp_force_limit_n = map.next_value()?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_tensor(map, "knots", self.knots.as_ref(), tensors)?;
write_tensor(map, "coordinates", self.coordinates.as_ref(), tensors)?;
map.serialize_entry("cost", &self.cost)?;
map.serialize_entry("cost_names", &self.cost_names)?;
write_tensor(map, "cost_terms", self.cost_terms.as_ref(), tensors)?;
write_word::<crate::v1::plan_update::Origin, M>(map, "origin", self.origin)?;
map.serialize_entry("nominal_cost", &self.nominal_cost)?;
map.serialize_entry("iterations", &self.iterations)?;
map.serialize_entry("simulated", &self.simulated)?;
map.serialize_entry("diverged", &self.diverged)?;
map.serialize_entry("stopped_by_deadline", &self.stopped_by_deadline)?;
map.serialize_entry("time_s", &self.time_s)?;
map.serialize_entry("last", &self.last)?;
write_message(map, "rollout", self.rollout.as_ref(), tensors)?;
map.serialize_entry("strain", &self.strain)?;
map.serialize_entry("strain_limit", &self.strain_limit)?;
map.serialize_entry("overstrained", &self.overstrained)?;
if let Some(value) = &self.grasp { map.serialize_entry("grasp", value)?; }
write_tensor(map, "grasp_costs", self.grasp_costs.as_ref(), tensors)?;
if let Some(value) = &self.grasp_force_n { map.serialize_entry("grasp_force_n", value)?; }
if let Some(value) = &self.grasp_force_limit_n { map.serialize_entry("grasp_force_limit_n", value)?; }

        Ok(())
    }
}
written!(crate::v1::PlanUpdate);

impl Words for crate::v1::plan_update::Origin {
    const KNOWN: &'static [&'static str] = &["NOMINAL", "MEAN", "SAMPLE"];
    fn number(word: &str) -> Option<i32> {
        Self::from_str_name(word).map(Into::into)
    }
    fn word(number: i32) -> Option<&'static str> {
        Self::try_from(number).ok().map(|value| value.as_str_name())
    }
}
word_written!(crate::v1::plan_update::Origin);

impl Fields for crate::v1::Observation {
    const NAME: &'static str = "Observation";
    const FIELDS: &'static [&'static str] = &["points", "nodes", "places", "weights", "velocities", "cameras"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.points = tensor(map, Dtype::Float32)?; }
1 => { only_one(&mut self.tracks, tensor(map, Dtype::Uint32)?.map(crate::v1::observation::Tracks::Nodes))?; }
2 => { only_one(&mut self.tracks, message(map)?.map(crate::v1::observation::Tracks::Places))?; }
3 => { self.weights = tensor(map, Dtype::Float32)?; }
4 => { self.velocities = tensor(map, Dtype::Float32)?; }
5 => { self.cameras = tensor(map, Dtype::Float32)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_tensor(map, "points", self.points.as_ref(), tensors)?;
if let Some(crate::v1::observation::Tracks::Nodes(value)) = &self.tracks { write_tensor(map, "nodes", Some(value), tensors)?; }
if let Some(crate::v1::observation::Tracks::Places(value)) = &self.tracks { write_message(map, "places", Some(value), tensors)?; }
write_tensor(map, "weights", self.weights.as_ref(), tensors)?;
write_tensor(map, "velocities", self.velocities.as_ref(), tensors)?;
write_tensor(map, "cameras", self.cameras.as_ref(), tensors)?;

        Ok(())
    }
}
written!(crate::v1::Observation);

impl Fields for crate::v1::observation::Places {
    const NAME: &'static str = "Places";
    const FIELDS: &'static [&'static str] = &["points", "node_positions"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.points = tensor(map, Dtype::Float32)?; }
1 => { self.node_positions = tensor(map, Dtype::Float32)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_tensor(map, "points", self.points.as_ref(), tensors)?;
write_tensor(map, "node_positions", self.node_positions.as_ref(), tensors)?;

        Ok(())
    }
}
written!(crate::v1::observation::Places);

impl Fields for crate::v1::RegisterStateRequest {
    const NAME: &'static str = "RegisterStateRequest";
    const FIELDS: &'static [&'static str] = &["twin", "observation", "initial", "controls", "world", "options", "grippers"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.twin = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.observation = message(map)?; }
2 => { self.initial = message(map)?; }
3 => { self.controls = tensor(map, Dtype::Float32)?; }
4 => { self.world = message(map)?; }
5 => { self.options = message(map)?; }
6 => { self.grippers = tensor(map, Dtype::Float32)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("twin", &self.twin)?;
write_message(map, "observation", self.observation.as_ref(), tensors)?;
write_message(map, "initial", self.initial.as_ref(), tensors)?;
write_tensor(map, "controls", self.controls.as_ref(), tensors)?;
write_message(map, "world", self.world.as_ref(), tensors)?;
write_message(map, "options", self.options.as_ref(), tensors)?;
write_tensor(map, "grippers", self.grippers.as_ref(), tensors)?;

        Ok(())
    }
}
written!(crate::v1::RegisterStateRequest);

impl Fields for crate::v1::RegisterOptions {
    const NAME: &'static str = "RegisterOptions";
    const FIELDS: &'static [&'static str] = &["near", "noise_m", "give", "settle_frames", "max_residual_m", "least_explained"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.near = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.noise_m = map.next_value()?; }
2 => { self.give = map.next_value()?; }
3 => { self.settle_frames = map.next_value()?; }
4 => { self.max_residual_m = map.next_value()?; }
5 => { self.least_explained = map.next_value()?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("near", &self.near)?;
if let Some(value) = &self.noise_m { map.serialize_entry("noise_m", value)?; }
if let Some(value) = &self.give { map.serialize_entry("give", value)?; }
if let Some(value) = &self.settle_frames { map.serialize_entry("settle_frames", value)?; }
if let Some(value) = &self.max_residual_m { map.serialize_entry("max_residual_m", value)?; }
if let Some(value) = &self.least_explained { map.serialize_entry("least_explained", value)?; }

        Ok(())
    }
}
written!(crate::v1::RegisterOptions);

impl Fields for crate::v1::RegisteredState {
    const NAME: &'static str = "RegisteredState";
    const FIELDS: &'static [&'static str] = &["state", "before", "after", "explained", "motion", "drift_mm", "worker"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.state = message(map)?; }
1 => { self.before = message(map)?; }
2 => { self.after = message(map)?; }
3 => { self.explained = message(map)?; }
4 => { self.motion = map.next_value::<Option<_>>()?.unwrap_or_default(); }
5 => { self.drift_mm = map.next_value::<Option<_>>()?.unwrap_or_default(); }
6 => { self.worker = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_message(map, "state", self.state.as_ref(), tensors)?;
write_message(map, "before", self.before.as_ref(), tensors)?;
write_message(map, "after", self.after.as_ref(), tensors)?;
write_message(map, "explained", self.explained.as_ref(), tensors)?;
map.serialize_entry("motion", &self.motion)?;
map.serialize_entry("drift_mm", &self.drift_mm)?;
map.serialize_entry("worker", &self.worker)?;

        Ok(())
    }
}
written!(crate::v1::RegisteredState);

impl Fields for crate::v1::Residual {
    const NAME: &'static str = "Residual";
    const FIELDS: &'static [&'static str] = &["median_mm", "mean_mm", "p95_mm"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.median_mm = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.mean_mm = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.p95_mm = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("median_mm", &self.median_mm)?;
map.serialize_entry("mean_mm", &self.mean_mm)?;
map.serialize_entry("p95_mm", &self.p95_mm)?;

        Ok(())
    }
}
written!(crate::v1::Residual);

impl Fields for crate::v1::Explained {
    const NAME: &'static str = "Explained";
    const FIELDS: &'static [&'static str] = &["points", "surface", "within_mm"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.points = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.surface = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.within_mm = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("points", &self.points)?;
map.serialize_entry("surface", &self.surface)?;
map.serialize_entry("within_mm", &self.within_mm)?;

        Ok(())
    }
}
written!(crate::v1::Explained);

impl Fields for crate::v1::CorrectOptions {
    const NAME: &'static str = "CorrectOptions";
    const FIELDS: &'static [&'static str] = &["noise_m", "give", "velocity_noise_m_s", "velocity_gain_per_s", "most_added_strain", "max_residual_m", "carry", "world", "grippers", "register_if_lost", "omit_state"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.noise_m = map.next_value()?; }
1 => { self.give = map.next_value()?; }
2 => { self.velocity_noise_m_s = map.next_value()?; }
3 => { self.velocity_gain_per_s = map.next_value()?; }
4 => { self.most_added_strain = map.next_value()?; }
5 => { self.max_residual_m = map.next_value()?; }
6 => { self.carry = map.next_value()?; }
7 => { self.world = message(map)?; }
8 => { self.grippers = tensor(map, Dtype::Float32)?; }
9 => { self.register_if_lost = map.next_value::<Option<_>>()?.unwrap_or_default(); }
10 => { self.omit_state = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        if let Some(value) = &self.noise_m { map.serialize_entry("noise_m", value)?; }
if let Some(value) = &self.give { map.serialize_entry("give", value)?; }
if let Some(value) = &self.velocity_noise_m_s { map.serialize_entry("velocity_noise_m_s", value)?; }
if let Some(value) = &self.velocity_gain_per_s { map.serialize_entry("velocity_gain_per_s", value)?; }
if let Some(value) = &self.most_added_strain { map.serialize_entry("most_added_strain", value)?; }
if let Some(value) = &self.max_residual_m { map.serialize_entry("max_residual_m", value)?; }
if let Some(value) = &self.carry { map.serialize_entry("carry", value)?; }
write_message(map, "world", self.world.as_ref(), tensors)?;
write_tensor(map, "grippers", self.grippers.as_ref(), tensors)?;
map.serialize_entry("register_if_lost", &self.register_if_lost)?;
map.serialize_entry("omit_state", &self.omit_state)?;

        Ok(())
    }
}
written!(crate::v1::CorrectOptions);

impl Fields for crate::v1::EvaluateTwinRequest {
    const NAME: &'static str = "EvaluateTwinRequest";
    const FIELDS: &'static [&'static str] = &["twin", "capture", "motion"];
    const REQUIRED: &'static [&'static str] = &["capture"];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.twin = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.capture = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.motion = message(map)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("twin", &self.twin)?;
map.serialize_entry("capture", &self.capture)?;
write_message(map, "motion", self.motion.as_ref(), tensors)?;

        Ok(())
    }
}
written!(crate::v1::EvaluateTwinRequest);

impl Fields for crate::v1::MotionRequest {
    const NAME: &'static str = "MotionRequest";
    const FIELDS: &'static [&'static str] = &["sequence"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.sequence = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("sequence", &self.sequence)?;

        Ok(())
    }
}
written!(crate::v1::MotionRequest);

impl Fields for crate::v1::PredictedMotion {
    const NAME: &'static str = "PredictedMotion";
    const FIELDS: &'static [&'static str] = &["sequence", "recording", "name", "fps", "frame_count", "start_frame", "train_frame_count", "every_frames", "positions", "track_m", "chamfer_l1_m"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.sequence = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.recording = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.fps = map.next_value::<Option<_>>()?.unwrap_or_default(); }
4 => { self.frame_count = map.next_value::<Option<_>>()?.unwrap_or_default(); }
5 => { self.start_frame = map.next_value::<Option<_>>()?.unwrap_or_default(); }
6 => { self.train_frame_count = map.next_value::<Option<_>>()?.unwrap_or_default(); }
7 => { self.every_frames = map.next_value::<Option<_>>()?.unwrap_or_default(); }
8 => { self.positions = tensor(map, Dtype::Float32)?; }
9 => { self.track_m = tensor(map, Dtype::Float32)?; }
10 => { self.chamfer_l1_m = tensor(map, Dtype::Float32)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("sequence", &self.sequence)?;
map.serialize_entry("recording", &self.recording)?;
map.serialize_entry("name", &self.name)?;
map.serialize_entry("fps", &self.fps)?;
map.serialize_entry("frame_count", &self.frame_count)?;
map.serialize_entry("start_frame", &self.start_frame)?;
map.serialize_entry("train_frame_count", &self.train_frame_count)?;
map.serialize_entry("every_frames", &self.every_frames)?;
write_tensor(map, "positions", self.positions.as_ref(), tensors)?;
write_tensor(map, "track_m", self.track_m.as_ref(), tensors)?;
write_tensor(map, "chamfer_l1_m", self.chamfer_l1_m.as_ref(), tensors)?;

        Ok(())
    }
}
written!(crate::v1::PredictedMotion);

impl Fields for crate::v1::Evaluation {
    const NAME: &'static str = "Evaluation";
    const FIELDS: &'static [&'static str] = &["twin", "capture", "quality", "worker", "motion"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.twin = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.capture = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.quality_json = document(map)?; }
3 => { self.worker = map.next_value::<Option<_>>()?.unwrap_or_default(); }
4 => { self.motion = message(map)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("twin", &self.twin)?;
map.serialize_entry("capture", &self.capture)?;
write_document(map, "quality", &self.quality_json)?;
map.serialize_entry("worker", &self.worker)?;
write_message(map, "motion", self.motion.as_ref(), tensors)?;

        Ok(())
    }
}
written!(crate::v1::Evaluation);

impl Fields for crate::v1::RenderSessionRequest {
    const NAME: &'static str = "RenderSessionRequest";
    const FIELDS: &'static [&'static str] = &["name", "slots", "cameras", "look", "props", "light", "depths", "labels"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.slots = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.cameras = messages(map)?; }
3 => { self.look = word::<crate::v1::render_session_request::Look, A>(map)?; }
4 => { self.props = messages(map)?; }
5 => { self.light = message(map)?; }
6 => { self.depths = map.next_value::<Option<_>>()?.unwrap_or_default(); }
7 => { self.labels = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("name", &self.name)?;
map.serialize_entry("slots", &self.slots)?;
write_messages(map, "cameras", &self.cameras, tensors)?;
write_word::<crate::v1::render_session_request::Look, M>(map, "look", self.look)?;
write_messages(map, "props", &self.props, tensors)?;
write_message(map, "light", self.light.as_ref(), tensors)?;
map.serialize_entry("depths", &self.depths)?;
map.serialize_entry("labels", &self.labels)?;

        Ok(())
    }
}
written!(crate::v1::RenderSessionRequest);

impl Words for crate::v1::render_session_request::Look {
    const KNOWN: &'static [&'static str] = &["SURFACE", "GAUSSIANS"];
    fn number(word: &str) -> Option<i32> {
        Self::from_str_name(word).map(Into::into)
    }
    fn word(number: i32) -> Option<&'static str> {
        Self::try_from(number).ok().map(|value| value.as_str_name())
    }
}
word_written!(crate::v1::render_session_request::Look);

impl Fields for crate::v1::PictureCamera {
    const NAME: &'static str = "PictureCamera";
    const FIELDS: &'static [&'static str] = &["name", "width", "height", "intrinsics", "pose", "background"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.width = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.height = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.intrinsics = tensor(map, Dtype::Float32)?; }
4 => { self.pose = tensor(map, Dtype::Float32)?; }
5 => { self.background = tensor(map, Dtype::Uint8)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("name", &self.name)?;
map.serialize_entry("width", &self.width)?;
map.serialize_entry("height", &self.height)?;
write_tensor(map, "intrinsics", self.intrinsics.as_ref(), tensors)?;
write_tensor(map, "pose", self.pose.as_ref(), tensors)?;
write_tensor(map, "background", self.background.as_ref(), tensors)?;

        Ok(())
    }
}
written!(crate::v1::PictureCamera);

impl Fields for crate::v1::Prop {
    const NAME: &'static str = "Prop";
    const FIELDS: &'static [&'static str] = &["sphere", "capsule", "cuboid", "convex_mesh", "pose", "color"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { only_one(&mut self.shape, message(map)?.map(crate::v1::prop::Shape::Sphere))?; }
1 => { only_one(&mut self.shape, message(map)?.map(crate::v1::prop::Shape::Capsule))?; }
2 => { only_one(&mut self.shape, message(map)?.map(crate::v1::prop::Shape::Cuboid))?; }
3 => { only_one(&mut self.shape, message(map)?.map(crate::v1::prop::Shape::ConvexMesh))?; }
4 => { self.pose = tensor(map, Dtype::Float32)?; }
5 => { self.color = tensor(map, Dtype::Uint8)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        if let Some(crate::v1::prop::Shape::Sphere(value)) = &self.shape { write_message(map, "sphere", Some(value), tensors)?; }
if let Some(crate::v1::prop::Shape::Capsule(value)) = &self.shape { write_message(map, "capsule", Some(value), tensors)?; }
if let Some(crate::v1::prop::Shape::Cuboid(value)) = &self.shape { write_message(map, "cuboid", Some(value), tensors)?; }
if let Some(crate::v1::prop::Shape::ConvexMesh(value)) = &self.shape { write_message(map, "convex_mesh", Some(value), tensors)?; }
write_tensor(map, "pose", self.pose.as_ref(), tensors)?;
write_tensor(map, "color", self.color.as_ref(), tensors)?;

        Ok(())
    }
}
written!(crate::v1::Prop);

impl Fields for crate::v1::Light {
    const NAME: &'static str = "Light";
    const FIELDS: &'static [&'static str] = &["direction", "ambient", "brightness"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.direction = tensor(map, Dtype::Float32)?; }
1 => { self.ambient = tensor(map, Dtype::Float32)?; }
2 => { self.brightness = tensor(map, Dtype::Float32)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_tensor(map, "direction", self.direction.as_ref(), tensors)?;
write_tensor(map, "ambient", self.ambient.as_ref(), tensors)?;
write_tensor(map, "brightness", self.brightness.as_ref(), tensors)?;

        Ok(())
    }
}
written!(crate::v1::Light);

impl Fields for crate::v1::RenderedSession {
    const NAME: &'static str = "RenderedSession";
    const FIELDS: &'static [&'static str] = &["cameras", "slots"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.cameras = messages(map)?; }
1 => { self.slots = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_messages(map, "cameras", &self.cameras, tensors)?;
map.serialize_entry("slots", &self.slots)?;

        Ok(())
    }
}
written!(crate::v1::RenderedSession);

impl Fields for crate::v1::rendered_session::Pictures {
    const NAME: &'static str = "Pictures";
    const FIELDS: &'static [&'static str] = &["colors", "depths", "labels"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.colors = tensor(map, Dtype::Float32)?; }
1 => { self.depths = tensor(map, Dtype::Float32)?; }
2 => { self.labels = tensor(map, Dtype::Float32)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_tensor(map, "colors", self.colors.as_ref(), tensors)?;
write_tensor(map, "depths", self.depths.as_ref(), tensors)?;
write_tensor(map, "labels", self.labels.as_ref(), tensors)?;

        Ok(())
    }
}
written!(crate::v1::rendered_session::Pictures);

impl Fields for crate::v1::Session {
    const NAME: &'static str = "Session";
    const FIELDS: &'static [&'static str] = &["name", "twin", "slots", "frames", "idle_timeout_s", "worker", "fidelity", "lost"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.twin = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.slots = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.frames = map.next_value::<Option<_>>()?.unwrap_or_default(); }
4 => { self.idle_timeout_s = map.next_value::<Option<_>>()?.unwrap_or_default(); }
5 => { self.worker = map.next_value::<Option<_>>()?.unwrap_or_default(); }
6 => { self.fidelity = word::<crate::v1::Fidelity, A>(map)?; }
7 => { self.lost = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("name", &self.name)?;
map.serialize_entry("twin", &self.twin)?;
map.serialize_entry("slots", &self.slots)?;
map.serialize_entry("frames", &self.frames)?;
map.serialize_entry("idle_timeout_s", &self.idle_timeout_s)?;
map.serialize_entry("worker", &self.worker)?;
write_word::<crate::v1::Fidelity, M>(map, "fidelity", self.fidelity)?;
map.serialize_entry("lost", &self.lost)?;

        Ok(())
    }
}
written!(crate::v1::Session);

impl Fields for crate::v1::Tracking {
    const NAME: &'static str = "Tracking";
    const FIELDS: &'static [&'static str] = &["lost", "misfit", "unexplained"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.lost = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.misfit = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.unexplained = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("lost", &self.lost)?;
map.serialize_entry("misfit", &self.misfit)?;
map.serialize_entry("unexplained", &self.unexplained)?;

        Ok(())
    }
}
written!(crate::v1::Tracking);

impl Fields for crate::v1::OpenSessionRequest {
    const NAME: &'static str = "OpenSessionRequest";
    const FIELDS: &'static [&'static str] = &["twin", "initial", "slots", "world", "grasps", "fidelity", "idle_timeout_s"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.twin = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.initial = message(map)?; }
2 => { self.slots = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.world = message(map)?; }
4 => { self.grasps = messages(map)?; }
5 => { self.fidelity = word::<crate::v1::Fidelity, A>(map)?; }
6 => { self.idle_timeout_s = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("twin", &self.twin)?;
write_message(map, "initial", self.initial.as_ref(), tensors)?;
map.serialize_entry("slots", &self.slots)?;
write_message(map, "world", self.world.as_ref(), tensors)?;
write_messages(map, "grasps", &self.grasps, tensors)?;
write_word::<crate::v1::Fidelity, M>(map, "fidelity", self.fidelity)?;
map.serialize_entry("idle_timeout_s", &self.idle_timeout_s)?;

        Ok(())
    }
}
written!(crate::v1::OpenSessionRequest);

impl Fields for crate::v1::GetSessionRequest {
    const NAME: &'static str = "GetSessionRequest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::GetSessionRequest);

impl Fields for crate::v1::GetSessionStatesRequest {
    const NAME: &'static str = "GetSessionStatesRequest";
    const FIELDS: &'static [&'static str] = &["slots"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.slots = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("slots", &self.slots)?;

        Ok(())
    }
}
written!(crate::v1::GetSessionStatesRequest);

impl Fields for crate::v1::SessionStates {
    const NAME: &'static str = "SessionStates";
    const FIELDS: &'static [&'static str] = &["states", "slots", "frames"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.states = message(map)?; }
1 => { self.slots = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.frames = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_message(map, "states", self.states.as_ref(), tensors)?;
map.serialize_entry("slots", &self.slots)?;
map.serialize_entry("frames", &self.frames)?;

        Ok(())
    }
}
written!(crate::v1::SessionStates);

impl Fields for crate::v1::AdvanceSessionRequest {
    const NAME: &'static str = "AdvanceSessionRequest";
    const FIELDS: &'static [&'static str] = &["name", "slots", "rollout"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.slots = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.rollout = message(map)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("name", &self.name)?;
map.serialize_entry("slots", &self.slots)?;
write_message(map, "rollout", self.rollout.as_ref(), tensors)?;

        Ok(())
    }
}
written!(crate::v1::AdvanceSessionRequest);

impl Fields for crate::v1::ForkSessionRequest {
    const NAME: &'static str = "ForkSessionRequest";
    const FIELDS: &'static [&'static str] = &["name", "from", "to"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.from = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.to = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("name", &self.name)?;
map.serialize_entry("from", &self.from)?;
map.serialize_entry("to", &self.to)?;

        Ok(())
    }
}
written!(crate::v1::ForkSessionRequest);

impl Fields for crate::v1::ResetSessionRequest {
    const NAME: &'static str = "ResetSessionRequest";
    const FIELDS: &'static [&'static str] = &["name", "slots", "initial"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.slots = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.initial = message(map)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("name", &self.name)?;
map.serialize_entry("slots", &self.slots)?;
write_message(map, "initial", self.initial.as_ref(), tensors)?;

        Ok(())
    }
}
written!(crate::v1::ResetSessionRequest);

impl Fields for crate::v1::CorrectSessionRequest {
    const NAME: &'static str = "CorrectSessionRequest";
    const FIELDS: &'static [&'static str] = &["name", "slots", "observation", "options"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.slots = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.observation = message(map)?; }
3 => { self.options = message(map)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("name", &self.name)?;
map.serialize_entry("slots", &self.slots)?;
write_message(map, "observation", self.observation.as_ref(), tensors)?;
write_message(map, "options", self.options.as_ref(), tensors)?;

        Ok(())
    }
}
written!(crate::v1::CorrectSessionRequest);

impl Fields for crate::v1::CorrectedSession {
    const NAME: &'static str = "CorrectedSession";
    const FIELDS: &'static [&'static str] = &["session", "corrections"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.session = message(map)?; }
1 => { self.corrections = messages(map)?; }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_message(map, "session", self.session.as_ref(), tensors)?;
write_messages(map, "corrections", &self.corrections, tensors)?;

        Ok(())
    }
}
written!(crate::v1::CorrectedSession);

impl Fields for crate::v1::corrected_session::Correction {
    const NAME: &'static str = "Correction";
    const FIELDS: &'static [&'static str] = &["slot", "before", "after", "moved_mm", "state", "tracking", "registered"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.slot = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.before = message(map)?; }
2 => { self.after = message(map)?; }
3 => { self.moved_mm = map.next_value::<Option<_>>()?.unwrap_or_default(); }
4 => { self.state = message(map)?; }
5 => { self.tracking = message(map)?; }
6 => { self.registered = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("slot", &self.slot)?;
write_message(map, "before", self.before.as_ref(), tensors)?;
write_message(map, "after", self.after.as_ref(), tensors)?;
map.serialize_entry("moved_mm", &self.moved_mm)?;
write_message(map, "state", self.state.as_ref(), tensors)?;
write_message(map, "tracking", self.tracking.as_ref(), tensors)?;
map.serialize_entry("registered", &self.registered)?;

        Ok(())
    }
}
written!(crate::v1::corrected_session::Correction);

impl Fields for crate::v1::StepSessionRequest {
    const NAME: &'static str = "StepSessionRequest";
    const FIELDS: &'static [&'static str] = &["name", "slot", "correction", "search", "execute_frames", "returns", "deadline_s"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.name = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.slot = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.correction = message(map)?; }
3 => { self.search = message(map)?; }
4 => { self.execute_frames = map.next_value::<Option<_>>()?.unwrap_or_default(); }
5 => { self.returns = message(map)?; }
6 => { self.deadline_s = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("name", &self.name)?;
map.serialize_entry("slot", &self.slot)?;
write_message(map, "correction", self.correction.as_ref(), tensors)?;
write_message(map, "search", self.search.as_ref(), tensors)?;
map.serialize_entry("execute_frames", &self.execute_frames)?;
write_message(map, "returns", self.returns.as_ref(), tensors)?;
map.serialize_entry("deadline_s", &self.deadline_s)?;

        Ok(())
    }
}
written!(crate::v1::StepSessionRequest);

impl Fields for crate::v1::SteppedSession {
    const NAME: &'static str = "SteppedSession";
    const FIELDS: &'static [&'static str] = &["corrected", "refused", "plan", "advanced", "state", "times", "lost"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.corrected = message(map)?; }
1 => { self.refused = message(map)?; }
2 => { self.plan = message(map)?; }
3 => { self.advanced = message(map)?; }
4 => { self.state = message(map)?; }
5 => { self.times = message(map)?; }
6 => { self.lost = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        write_message(map, "corrected", self.corrected.as_ref(), tensors)?;
write_message(map, "refused", self.refused.as_ref(), tensors)?;
write_message(map, "plan", self.plan.as_ref(), tensors)?;
write_message(map, "advanced", self.advanced.as_ref(), tensors)?;
write_message(map, "state", self.state.as_ref(), tensors)?;
write_message(map, "times", self.times.as_ref(), tensors)?;
map.serialize_entry("lost", &self.lost)?;

        Ok(())
    }
}
written!(crate::v1::SteppedSession);

impl Fields for crate::v1::stepped_session::Times {
    const NAME: &'static str = "Times";
    const FIELDS: &'static [&'static str] = &["correct_s", "plan_s", "advance_s", "total_s"];
    const REQUIRED: &'static [&'static str] = &[];
    #[allow(unused_variables)]
    fn read<'de, A: MapAccess<'de>>(&mut self, field: usize, map: &mut A) -> Result<(), A::Error> {
        match field {
            0 => { self.correct_s = map.next_value::<Option<_>>()?.unwrap_or_default(); }
1 => { self.plan_s = map.next_value::<Option<_>>()?.unwrap_or_default(); }
2 => { self.advance_s = map.next_value::<Option<_>>()?.unwrap_or_default(); }
3 => { self.total_s = map.next_value::<Option<_>>()?.unwrap_or_default(); }

            _ => {}
        }
        Ok(())
    }
    #[allow(unused_variables)]
    fn write<M: SerializeMap>(&self, tensors: TensorFormat, map: &mut M) -> Result<(), M::Error> {
        map.serialize_entry("correct_s", &self.correct_s)?;
map.serialize_entry("plan_s", &self.plan_s)?;
map.serialize_entry("advance_s", &self.advance_s)?;
map.serialize_entry("total_s", &self.total_s)?;

        Ok(())
    }
}
written!(crate::v1::stepped_session::Times);

impl Fields for crate::v1::CloseSessionRequest {
    const NAME: &'static str = "CloseSessionRequest";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::CloseSessionRequest);

impl Fields for crate::v1::CloseSessionResponse {
    const NAME: &'static str = "CloseSessionResponse";
    const FIELDS: &'static [&'static str] = &[];
    const REQUIRED: &'static [&'static str] = &[];
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
written!(crate::v1::CloseSessionResponse);
