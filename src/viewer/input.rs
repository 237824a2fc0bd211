//! The actions of keys and mouse.

use super::{
    axis,
    keys::{self, Action},
    painter::Painter,
    pose::Pose,
    probe,
    request::{Boxes, Look, Style},
    shell::Event,
    timeline::Model,
    window::{App, Framing, STEP},
};
use crate::{heat, ray::SceneHit, render::Mode};
use glam::DMat3;
use std::{
    ops::ControlFlow as Flow,
    sync::{Arc, PoisonError},
    time::Instant,
};
use winit::{
    event::{ElementState, KeyEvent, MouseScrollDelta},
    event_loop::ActiveEventLoop,
};

/// The distance changes by this factor with each pixel of a right drag or of scrolling on a touchpad.
const FACTOR_OF_PIXEL: f64 = 1.01;
/// The distance changes by this factor with each notch of the wheel.
const FACTOR_OF_NOTCH: f64 = 1.1;

impl App {
    /// Performs the action of a key.
    fn act(&mut self, action: Action, event_loop: &ActiveEventLoop) {
        let style = &mut self.style;
        let toggled = |now: Look, look: Look| if now == look { Look::Full } else { look };
        let on = |on: bool| if on { "on" } else { "off" };
        let mut message = None;
        match action {
            Action::Quit => event_loop.exit(),
            Action::View(number) => return self.view(number),
            Action::Home => self.orbit.go_to(self.home),
            Action::Frame => return self.frame(Framing::Under(self.hit_under_mouse())),
            Action::TurnUp => return self.turn_up(),
            Action::Preview => style.look = toggled(style.look, Look::Preview),
            Action::Normals => style.look = toggled(style.look, Look::Normals),
            Action::Cost => {
                style.look = toggled(style.look, Look::Cost);
                if style.look == Look::Cost {
                    message = Some(format!(
                        "nodes and primitives tested: 1 is dark, {} yellow",
                        heat::HOTTEST
                    ));
                }
            }
            Action::Edges => {
                style.toggle_edges(self.options.settings.edges);
                message = Some(format!("edges {}", on(style.settings.edges.is_some())));
            }
            Action::Antialias => {
                style.antialias = !style.antialias;
                message = Some(format!("anti-aliasing {}", on(style.antialias)));
            }
            Action::Brute => {
                style.brute = !style.brute;
                message = Some(format!("BVH {}", on(!style.brute)));
            }
            Action::Leaves => {
                style.boxes = match style.boxes {
                    Boxes::Leaves => Boxes::Hidden,
                    _ => Boxes::Leaves,
                };
            }
            Action::LevelUp | Action::LevelDown => {
                let level = match (style.boxes, action) {
                    (Boxes::Level(0), Action::LevelUp) => None,
                    (Boxes::Level(level), Action::LevelUp) => Some(level - 1),
                    (Boxes::Level(level), _) => Some((level + 1).min(self.timeline.now().bvh.stats().depth)),
                    _ => Some(0),
                };
                style.boxes = level.map_or(Boxes::Hidden, Boxes::Level);
                message = Some(level.map_or("no boxes".into(), |level| format!("boxes at level {level}")));
            }
            Action::Mode => {
                let mode = &mut style.settings.mode;
                *mode = match *mode {
                    Mode::Packet => Mode::Scalar,
                    Mode::Scalar => Mode::Packet,
                };
                let is_packet = *mode == Mode::Packet;
                message = Some(if is_packet { "packets" } else { "single rays" }.into());
                self.panels.figures = true;
            }
            Action::PrintCamera => {
                self.print_camera();
                message = Some("camera printed".into());
            }
            Action::Save => {
                self.playback.stop();
                self.saves = true;
                message = Some("saving".into());
                self.save_if_due();
            }
            Action::Play => self.play(),
            Action::Fly(_) | Action::Step(_) => {}
            Action::Probe => self.panels.probe = !self.panels.probe,
            Action::Figures => self.panels.figures = !self.panels.figures,
            Action::Help => self.panels.help = !self.panels.help,
        }
        if let Some(message) = message {
            self.say(message);
        }
        self.ask();
        self.redraw();
    }

    /// Goes to a classic viewpoint of a scene, or shows a mesh from one of its sides.
    fn view(&mut self, number: u32) {
        if self.options.is_mesh {
            self.frame(Framing::Side(number as usize - 1));
        } else if let Some(pose) = Pose::classic_view(number) {
            self.orbit.go_to(pose);
            self.ask();
        }
    }

    fn hit_under_mouse(&self) -> Option<SceneHit> {
        let pixel = self.mouse_pixel()?;
        let (_, hit, _) = probe::pick(&self.timeline.now(), &self.orbit.camera(), self.size, pixel);
        hit.is_hit().then_some(hit)
    }

    /// Frames something now, or as soon as the objects of a large scene are known.
    pub(super) fn frame(&mut self, framing: Framing) {
        let model = self.timeline.now();
        if !model.has_objects() {
            self.say("looking for objects");
            let timeline = Arc::clone(&self.timeline);
            let (proxy, pose) = (self.proxy.clone(), self.orbit.pose());
            let looking = super::on_thread(move || {
                model.objects();
                drop(model);
                // Fails once the window is closed.
                let _ = proxy.send_event(Event::Objects(timeline, framing, pose));
            });
            if let Err(why) = looking {
                self.say(why);
            }
            return;
        }
        let [width, height] = self.size.map(f64::from);
        let aspect = width / height.max(1.0);
        // Of the mesh on the screen: one that is loaded again is not there yet, and turns the camera when it is.
        let up = axis::nearest(self.turn.transpose() * self.up[1].vector());
        let bounds = |under| {
            let bounds = model.objects().bounds(&model.scene, under, up);
            (bounds, model.scene.offset())
        };
        match framing {
            Framing::Under(under) => self.orbit.frame(bounds(under), aspect),
            Framing::Side(side) => {
                self.orbit.frame_side(bounds(None), aspect, side, up);
                self.say(axis::SIDES[side]);
            }
        }
        self.ask();
    }

    /// Turns a mesh so that the next axis points up. The host loads it again with its light turned.
    fn turn_up(&mut self) {
        let [first, now] = self.up;
        let Some(reload) = self.reload.as_ref().filter(|_| self.options.is_mesh) else {
            return self.say("a scene has its own up axis: nothing turns");
        };
        let up = axis::next(now, first);
        let rotation = axis::turn(now, up);
        if let Err(why) = self.host.turn_up(up, rotation) {
            return self.say(why);
        }
        reload.ask();
        self.up = [first, up];
        self.turn = rotation * self.turn;
    }

    /// Turns the camera as the mesh on the screen was turned. One at its start follows that.
    pub(super) fn turn_camera(&mut self) {
        if self.turn == DMat3::IDENTITY {
            return;
        }
        let turn = std::mem::replace(&mut self.turn, DMat3::IDENTITY);
        if self.orbit.pose() != self.home {
            self.orbit.go_to(self.orbit.pose().rotated(turn));
        }
        self.say(format!("{} is up", self.up[1].name()));
    }

    /// Prints the command that makes the picture at rest.
    fn print_camera(&self) {
        let shown = self.style;
        let style = Style {
            look: Look::Full,
            ..shown
        };
        let settings = style.settings(self.size, style.last_samples());
        let frame = self.playback.frame();
        let mut view = self.orbit.pose().options();
        if let Some(layer) = shown.layer() {
            view += &format!(" --aov={layer}");
        }
        self.host.say(&view, frame, &settings, style.transfer);
    }

    /// Saves the picture if requested, once the scene is at the frame.
    pub(super) fn save_if_due(&mut self) {
        let model = self.timeline.now();
        if self.saves && model.frame() == self.playback.frame() {
            self.saves = false;
            self.save(model);
        }
    }

    /// Traces and writes the picture at full quality on another thread. The scene does not move meanwhile.
    fn save(&self, model: Arc<Model>) {
        let (host, proxy) = (Arc::clone(&self.host), self.proxy.clone());
        let (writing, shared) = (Arc::clone(&self.writing), Arc::clone(&self.shared));
        let mut request = self.request();
        // The fastest way to the same picture: brute force takes all samples everywhere.
        request.style.settings.adaptive &= !request.style.brute;
        request.style.brute &= request.style.look == Look::Cost;
        request.style.settings.mode = Mode::Packet;
        let samples = request.style.last_samples();
        *writing.lock().unwrap_or_else(PoisonError::into_inner) += 1;
        let tracing = super::on_thread(move || {
            let mut painter = Painter::new(&model);
            let go_on = |_| {
                if shared.has_ended() {
                    Flow::Break(())
                } else {
                    Flow::Continue(())
                }
            };
            let traced = painter.trace(&request, request.size, samples, &go_on);
            let mut unsaved = writing.lock().unwrap_or_else(PoisonError::into_inner);
            // The program does not wait for a file that is begun now.
            if shared.has_ended() {
                return;
            }
            let traced = traced.map_err(|error| error.to_string());
            let saved = traced.and_then(|_| host.save(&painter.film));
            // An error is shown, unless the window has been closed meanwhile.
            if saved.is_ok() || !shared.has_ended() {
                *unsaved -= 1;
            }
            drop(unsaved);
            let _ = proxy.send_event(Event::Saved(saved));
        });
        if let Err(why) = tracing {
            *self.writing.lock().unwrap_or_else(PoisonError::into_inner) -= 1;
            let _ = self.proxy.send_event(Event::Saved(Err(why)));
        }
    }

    pub(super) fn key(&mut self, event: &KeyEvent, event_loop: &ActiveEventLoop) {
        if event.state == ElementState::Released {
            if self.held.release(event.physical_key) {
                self.fly();
            }
            return;
        }
        match keys::action(&event.logical_key) {
            Some(Action::Step(steps)) => self.step(steps),
            Some(Action::Fly(direction)) if !event.repeat => {
                if !self.held.flies() {
                    // A tap is a step as well.
                    self.flown_at = Instant::now().checked_sub(STEP * 2);
                }
                self.held.press(event.physical_key, direction);
                self.fly();
            }
            Some(action) if !event.repeat => self.act(action, event_loop),
            _ => {}
        }
    }

    /// Flies on for the time since the last step.
    pub(super) fn fly(&mut self) {
        if !self.held.flies() {
            self.flown_at = None;
            return;
        }
        let now = Instant::now();
        let seconds = self.flown_at.map_or(0.0, |at| (now - at).as_secs_f64()).min(0.1);
        self.flown_at = Some(now);
        let [right, up, forward] = self.held.flight().map(|part| part * seconds);
        self.orbit.fly(right, up, forward);
        self.ask();
    }

    pub(super) fn mouse_moved(&mut self, [right, down]: [f64; 2]) {
        if self.mouse.left {
            self.orbit.turn(right, down);
        } else if self.mouse.right {
            self.orbit.approach(FACTOR_OF_PIXEL.powf(down));
        }
        if self.mouse.left || self.mouse.right {
            self.ask();
        } else if self.panels.probe {
            self.redraw();
        }
    }

    pub(super) fn wheel(&mut self, delta: MouseScrollDelta) {
        let factor = match delta {
            MouseScrollDelta::LineDelta(_, lines) => FACTOR_OF_NOTCH.powf(-f64::from(lines)),
            MouseScrollDelta::PixelDelta(pixels) => FACTOR_OF_PIXEL.powf(-pixels.y),
        };
        self.orbit.approach(factor);
        self.ask();
    }
}
