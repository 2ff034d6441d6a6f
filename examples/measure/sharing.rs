//! Sharing out forces over four feet, tick by tick, as the guide says: the scene of `examples/forces`, pushed with 0.3 and 0.6 of its friction
//! at 30°. The forces count on two thirds of it.

#[path = "../forces/scene.rs"]
mod scene;

use crate::counter::Counter;
use cortex_m_semihosting::hprintln;
use nalgebra::SVector;
use stiction::{Error, Factor, Real, Scene, Solver};

/// `α`: the price of forces that differ from those to which they are drawn.
const ALPHA: f64 = 0.1;

pub(crate) struct Sharing<T: Real> {
    scene: Scene<T, 6, 3, 4, 0, 4>,
    factor: Factor<T, 6, 3, 4>,
    solver: Solver<T, 6, 3, 4>,
}

/// `-b` for a push in units of the friction that there is, turned by a hundredth of a radian or not.
fn free_impulse<T: Real>(push: f64, turned: f64) -> SVector<T, 6> {
    let push = push * scene::MU;
    let wrench = [push * (0.866 - 0.5 * turned), push * (0.5 + 0.866 * turned), 1.0, 0.0, 0.0, 0.0];
    wrench.map(|share: f64| T::literal(-share * scene::WEIGHT)).into()
}

impl<T: Real> Sharing<T> {
    pub(crate) const fn new() -> Self {
        Self { scene: Scene::new(), factor: Factor::empty(), solver: Solver::new() }
    }

    /// Instructions of a factor, and of solves to 1e-4: of the first tick, and of the twelfth, whose push has turned; bytes. `None` if
    /// something does not succeed.
    #[inline(never)]
    pub(crate) fn measure(&mut self, counter: &mut Counter) -> Option<()> {
        scene::fill(&mut self.scene, ALPHA, scene::MU / 1.5).ok()?;
        let mut ok = true;
        let count = counter.count(|| ok &= self.factor.prepare(&self.scene).is_ok())?;
        hprintln!("sharing prepare {}", count);
        for (name, push) in [("sharing", 0.3), ("sharing_slip", 0.6)] {
            self.solver.reset();
            ok &= self.draw(0.0).is_ok();
            let first = free_impulse(push, 0.0);
            let count = counter.count(|| ok &= self.solve(&first))?;
            hprintln!("{} cold_1e-4 {}", name, count);
            for _ in 0..10 {
                ok &= self.draw(0.99).is_ok() && self.solve(&first);
            }
            ok &= self.draw(0.99).is_ok();
            let turned = free_impulse(push, 0.01);
            let count = counter.count(|| ok &= self.solve(&turned))?;
            hprintln!("{} warm_1e-4 {}", name, count);
        }
        hprintln!("sharing ram_scene {}", size_of_val(&self.scene));
        hprintln!("sharing ram_factor {}", size_of_val(&self.factor));
        hprintln!("sharing ram_solver {}", size_of_val(&self.solver));
        ok.then_some(())
    }

    /// Draws the forces to a share of the last ones.
    fn draw(&mut self, share: f64) -> Result<(), Error> {
        for foot in 0..self.scene.contacts().len() {
            let last = self.solver.solution().contacts.get(foot);
            let offset = last.map(|foot| foot.impulse * T::literal(-share * ALPHA));
            self.scene.set_offset(foot, &offset.unwrap_or_else(SVector::zeros))?;
        }
        Ok(())
    }

    #[inline(never)]
    fn solve(&mut self, free_impulse: &SVector<T, 6>) -> bool {
        let settings = scene::settings(1e-4);
        let solution = self.solver.solve(&self.scene, &self.factor, free_impulse, &settings);
        solution.is_ok_and(|solution| solution.is_solved())
    }
}
