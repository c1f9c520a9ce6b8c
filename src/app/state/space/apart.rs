//! Pulling a photo's layers apart: their places in space, and the one under a position in the view.

use glam::DVec3;

use super::FIELD_RAD;
use super::exploded::Panes3D;
use super::picking::ViewPixel;
use super::scene::ShownScene;
use crate::state::State;
use crate::state::flat::version::LayersVersion;
use crate::state::panes::Pane;
use crate::state::session::Session;
use quadratura_base::scene::PhotoId;
use quadratura_document::Stack;
use quadratura_editing::peel::Opacities;
use quadratura_layers::LayerIndex;
use quadratura_projection::exploded::Stand;
use quadratura_view::flight::FrameLens;
use quadratura_view::navigation::Viewpoint;

/// The height of layer pictures, as a share of the site's radius, so that navigation feels the same as in the site.
const HEIGHT_SHARE: f64 = 0.8;

impl State {
    /// Pulls the selected photo's layers apart and views them from the side, or puts them back.
    pub fn toggle_exploded(&mut self) {
        if self.space.exploded.photo.take().is_some() {
            let now_s = self.window.now_s;
            let back = self.space.exploded.back.take();
            if let (Some((view, through)), Some(session)) = (back, &self.session) {
                self.space.fly(view, through, session, now_s);
            }
            return;
        }
        self.space.exploded.back = Some((self.space.viewpoint, self.space.through));
        self.pull_apart();
    }

    /// Pulls apart the layers of the selected photo.
    pub fn pull_apart(&mut self) {
        let Some(photo) = self.selected_photo() else { return };
        self.panes.show(Pane::Space);
        self.space.exploded.photo = Some(photo);
        self.space.exploded.now_apart = 0.0;
        let Some(there) = self.scene().and_then(|scene| scene.view_of_layers_apart()) else { return };
        self.space.exploded.begins = true;
        self.fly_to_viewpoint(there);
    }

    /// Returns the stack of the selected photo.
    pub fn selected_stack(&self) -> Option<&Stack> {
        self.session.as_ref()?.stack_of(self.selected_photo()?).map(|stack| &**stack)
    }
}

/// Returns the order of a photo's farthest layer.
fn last_order(session: &Session, photo: PhotoId) -> u32 {
    let stack = session.stack_of(photo);
    stack.iter().flat_map(|stack| &stack.image_layers).map(|layer| layer.order).max().unwrap_or(0)
}

impl<'a> ShownScene<'a> {
    /// Returns the view of all layers that are pulled apart; none where nothing is.
    pub fn view_of_layers_apart(&self) -> Option<Viewpoint> {
        let (photo, session) = (self.space.exploded.photo?, self.session);
        let stand = self.stand(self.space.exploded.apart)?;
        let (lens, up) = (FrameLens::with_field_of_view(FIELD_RAD), session.scene_frame.up);
        Some(stand.side_view(last_order(session, photo), lens, up, self.space.width().min(1.0)))
    }

    /// Returns the version of the layers that are pulled apart; none where nothing is, or where no layers are built.
    pub fn version_apart(&self) -> Option<LayersVersion> {
        LayersVersion::new(self.session, self.space.exploded.photo?)
    }

    /// Returns the layer pictures of the photo's current stack.
    pub fn panes_apart(&self) -> Option<&'a Panes3D> {
        self.space.exploded.made.get(&self.version_apart()?)
    }

    /// Returns the positions of the layers in space for a spacing.
    pub fn stand(&self, apart: f32) -> Option<Stand> {
        let (session, place) = (self.session, self.space.exploded.photo?);
        let photo = session.opened.site.photos.get(place.index())?;
        let height = HEIGHT_SHARE * session.scene_frame.radius;
        let step = f64::from(apart) / f64::from(last_order(session, place).max(1));
        Some(Stand::with_height(photo.camera, photo.pose, height, step))
    }

    /// Returns the opacities of the layers that are pulled apart.
    pub fn opacities_apart(&self) -> Opacities {
        let Some(photo) = self.space.exploded.photo else { return Opacities::default() };
        let stack = self.session.stack_of(photo);
        stack.map(|stack| self.layer_views.drawn(photo, stack)).unwrap_or_default()
    }

    /// Returns the nearest layer under a position in the view, for a spacing: the point in world space, and the layer's
    /// index in the stack.
    pub fn layer_at(&self, pixel: &ViewPixel, apart: f32) -> Option<(DVec3, LayerIndex)> {
        let (stand, panes) = (self.stand(apart)?, self.panes_apart()?);
        let (eye, ray) = (pixel.viewpoint.position(), pixel.ray());
        let orders: Vec<u32> = panes.pictures.iter().map(|pane| pane.order).collect();
        let opacities = self.opacities_apart();
        stand.from_behind(&orders, eye).into_iter().rev().find_map(|place| {
            let pane = &panes.pictures[place];
            let (t, px) = stand.meet(pane.order, eye, ray)?;
            let is_shown = opacities.of(pane.layer) > 0;
            (is_shown && pane.has(px.x, px.y)).then_some((eye + ray * t, pane.layer))
        })
    }
}
