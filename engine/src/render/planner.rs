//! From a scene to a frame's plan, keeping what does not change.

use std::sync::Arc;

use wgpu::{Features, TextureFormat};

use super::frame::plan_frame;
use super::renderer::RenderError;
use super::request::{Adapter, FrameRequest};
use crate::plan::FramePlan;
use crate::scene::{Scene, SceneSnapshot};
use crate::shadow::{Cache, Catalog, Registry};

/// Plans frames of scenes with one catalog of techniques. Needs no device.
///
/// A frame like the one before has its plan, and allocates nothing for it.
#[derive(Debug)]
pub struct Planner {
    catalog: Catalog,
    cache: Cache,
    /// The scene's snapshot of one revision, with its shadow nodes by light.
    snapshot: Option<(u64, Arc<SceneSnapshot>, Arc<Registry>)>,
    last: Option<Planned>,
}

/// A plan and all that it was made for.
#[derive(Debug)]
struct Planned {
    /// The scene's.
    revision: u64,
    request: FrameRequest,
    adapter_name: String,
    features: Features,
    max_size_px: u32,
    multisampled: Vec<TextureFormat>,
    plan: Arc<FramePlan>,
}

impl Planned {
    fn is_for(&self, scene: &Scene, request: &FrameRequest, adapter: &Adapter<'_>) -> bool {
        self.revision == scene.revision()
            && self.request == *request
            && self.adapter_name == adapter.name
            && self.features == adapter.features
            && self.max_size_px == adapter.max_size_px
            && self.multisampled == adapter.multisampled
    }
}

impl Planner {
    /// A planner that knows the techniques of `catalog`.
    pub fn new(catalog: Catalog) -> Self {
        Self { catalog, cache: Cache::new(), snapshot: None, last: None }
    }

    /// The techniques it knows.
    pub fn catalog(&self) -> &Catalog {
        &self.catalog
    }

    /// How many cached results were computed since the planner was made: in a frame in which nothing moved, none.
    pub fn computed(&self) -> u64 {
        self.cache.computed()
    }

    /// The scene flattened, and its shadow nodes by light; kept until the scene changes.
    ///
    /// # Errors
    /// What is wrong with the scene or its shadow nodes.
    pub fn snapshot(&mut self, scene: &Scene) -> Result<(Arc<SceneSnapshot>, Arc<Registry>), RenderError> {
        if let Some((revision, snapshot, registry)) = &self.snapshot
            && *revision == scene.revision()
        {
            return Ok((Arc::clone(snapshot), Arc::clone(registry)));
        }
        let snapshot = Arc::new(scene.snapshot()?);
        let registry = Arc::new(Registry::collect(&snapshot, &self.catalog)?);
        self.snapshot = Some((scene.revision(), Arc::clone(&snapshot), Arc::clone(&registry)));
        Ok((snapshot, registry))
    }

    /// The plan of a frame of `scene`; that of the last one where nothing has changed since.
    ///
    /// # Errors
    /// What is wrong with the scene, its shadow nodes or the request.
    pub fn plan(
        &mut self,
        scene: &Scene,
        request: &FrameRequest,
        adapter: &Adapter<'_>,
    ) -> Result<Arc<FramePlan>, RenderError> {
        if let Some(last) = self.last.as_ref().filter(|last| last.is_for(scene, request, adapter)) {
            return Ok(Arc::clone(&last.plan));
        }
        let (snapshot, registry) = self.snapshot(scene)?;
        // A plan that is taken again asks the cache for nothing, so nothing of it must be dropped meanwhile.
        self.cache.begin_frame();
        let plan = Arc::new(plan_frame(&snapshot, &registry, request, adapter, &self.cache)?);
        self.last = Some(Planned {
            revision: scene.revision(),
            request: request.clone(),
            adapter_name: adapter.name.into(),
            features: adapter.features,
            max_size_px: adapter.max_size_px,
            multisampled: adapter.multisampled.to_vec(),
            plan: Arc::clone(&plan),
        });
        Ok(plan)
    }
}
