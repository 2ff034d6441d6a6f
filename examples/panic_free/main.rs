//! Links only if the kernel reaches no panic: the panic handler calls a symbol nobody defines.
//!
//! No allocator is linked either, or the link would ask for one. Built by `.ci/firmware` at
//! `opt-level` 3 and "s"; `--cfg violate` puts an indexing panic in, to see that it is caught.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    println!("a proof by linking: add --target thumbv7em-none-eabihf");
}

#[cfg(target_os = "none")]
mod proof {
    use core::fmt::{self, Write};
    use core::hint::black_box;
    use cortex_m_rt::entry;
    use cortex_m_semihosting::debug;
    use nalgebra::{SMatrix, SVector};
    use stiction::time_stepping as law;
    use stiction::{
        Acceleration, AdmmFactor, AdmmSolver, Contact, Factor, FrictionCone, Kernel, Real, Scene,
        Settings, SlipUpdate, Solver,
    };

    mod undefined {
        #![allow(unsafe_code)]
        unsafe extern "C" {
            pub(super) safe fn a_panic_is_reachable() -> !;
        }
    }

    #[panic_handler]
    fn panic(_: &core::panic::PanicInfo) -> ! {
        undefined::a_panic_is_reachable()
    }

    /// Takes text, as a log does.
    struct Sink;

    impl Write for Sink {
        fn write_str(&mut self, text: &str) -> fmt::Result {
            black_box(text);
            Ok(())
        }
    }

    struct Bench<T: Real, const N: usize, const D: usize, const C: usize> {
        scene: Scene<T, N, D, C>,
        factor: Factor<T, N, D, C>,
        admm_factor: AdmmFactor<T, N, D, C>,
        solver: Solver<T, N, D, C>,
        admm: AdmmSolver<T, N, D, C>,
        kernel: Kernel<T, N, D, C>,
    }

    impl<T: Real, const N: usize, const D: usize, const C: usize> Bench<T, N, D, C> {
        const fn new() -> Self {
            Self {
                scene: Scene::new(),
                factor: Factor::empty(),
                admm_factor: AdmmFactor::empty(),
                solver: Solver::new(),
                admm: AdmmSolver::with(Acceleration::Nesterov, SlipUpdate::OuterLoop),
                kernel: Kernel::new(),
            }
        }

        /// Every public call, on data the compiler knows nothing of.
        fn call(&mut self) {
            let mass: SMatrix<T, N, N> = black_box(SMatrix::identity());
            let contact: Contact<T, N, D> = black_box(Contact {
                jacobian: SMatrix::zeros(),
                offset: SVector::zeros(),
                mu: T::ONE,
                key: 7,
            });
            let push: SVector<T, N> = black_box(SVector::zeros());
            let index = black_box(1);
            let Self {
                scene,
                factor,
                admm_factor,
                solver,
                admm,
                ..
            } = self;
            // An error, so that it is written out as well.
            if let Err(error) = black_box(scene.set_mass(&mass)) {
                let _ = write!(Sink, "{error}");
            }
            let _ = black_box(scene.push(&contact));
            let _ = black_box(scene.set_offset(index, &contact.offset));
            let _ = black_box(scene.set_friction(index, contact.mu));
            let _ = black_box(scene.set_delassus(&black_box([[[[T::ONE; D]; C]; D]; C])));
            let _ = black_box(scene.set_jacobian(index, &contact.jacobian));
            black_box(law::free_impulse(&mass, &push, &push, contact.mu));
            black_box(law::moving_surface(&contact.jacobian, &push));
            let _ = black_box(factor.prepare(scene));
            let _ = black_box(admm_factor.prepare(scene));
            let _ = black_box(admm_factor.set_penalty(black_box(T::ONE)));
            let _ = black_box(Factor::new(scene).is_ok());
            let _ = black_box(AdmmFactor::new(scene).is_ok());
            black_box(factor.is_current(scene));
            let number = black_box(T::ONE);
            let _ = black_box(law::gap(number, number, number, number));
            let _ = black_box(law::restitution(number, -number, number, number));

            let settings: Settings<T> = black_box(Settings::default());
            let _ = black_box(solver.solve(scene, factor, &push, &settings).is_ok());
            solver.reset();
            let _ = black_box(admm.solve(scene, admm_factor, &push, &settings).is_ok());
            let _ = black_box(admm.resume(scene, admm_factor, &push, &settings).is_ok());
            let impulses = black_box([(0, contact.offset); C]);
            let _ = black_box(solver.set_impulses(&impulses));
            let _ = black_box(solver.resume(scene, factor, &push, &settings).is_ok());
            black_box(solver.solution().worst_contact(scene, factor, &settings));
            black_box(solver.solution().is_usable(number));
            black_box(solver.solution().work.total());
            let _ = write!(Sink, "{}", solver.solution().status);
            admm.reset();
            let _ = black_box(admm.set_impulses(&impulses));
            if let Some(parts) = black_box(&*factor).parts() {
                *factor = Factor::from_parts(black_box(&parts));
            }
            if let Some(parts) = black_box(&*admm_factor).parts() {
                *admm_factor = AdmmFactor::from_parts(black_box(&parts));
            }
            scene.clear_contacts();
            self.call_kernel(&mass, &contact, &push, &settings);

            if let Some(cone) = black_box(FrictionCone::new(black_box(contact.mu))) {
                black_box(cone.contains(&contact.offset));
                black_box(cone.project(&contact.offset));
                black_box(cone.dual().project(&contact.offset));
            }
            #[cfg(violate)]
            black_box(push[index]);
        }

        /// The same by way of `Kernel`, with a scene of constants.
        fn call_kernel(
            &mut self,
            mass: &SMatrix<T, N, N>,
            contact: &Contact<T, N, D>,
            push: &SVector<T, N>,
            settings: &Settings<T>,
        ) {
            let kernel = &mut self.kernel;
            let contacts = core::array::from_fn(|_| contact.clone());
            *kernel.scene_mut() = black_box(Scene::from_parts(*mass, contacts));
            let _ = black_box(kernel.solve(push, settings).is_ok());
            if let Err(error) = black_box(kernel.resume(push, settings)) {
                let _ = write!(Sink, "{error}");
            }
            black_box(kernel.worst_contact(settings));
            black_box(kernel.solution().error);
            kernel.solver_mut().reset();
            kernel.scene_mut().clear_contacts();
        }
    }

    /// A scene of contacts and joint rows.
    type Mixed = Kernel<f32, 12, 6, 4, stiction::Mixed>;

    fn call_mixed(kernel: &mut Mixed) {
        let row: SVector<f32, 12> = black_box(SVector::zeros());
        let numbers = black_box([0.1_f32; 4]);
        let [a, b, c, d] = numbers;
        let gains: law::Motor<f32> = black_box(law::Motor {
            stiffness: a,
            damping: b,
            feedforward: c,
            limit: d,
        });
        let contact: Contact<f32, 12, 6> = black_box(Contact {
            jacobian: SMatrix::zeros(),
            offset: SVector::zeros(),
            mu: a,
            key: 7,
        });
        let surface = black_box(stiction::Surface {
            friction: [a, b],
            spin: c,
            roll: [a, d],
            compliance: [
                law::compliance(a, b, c).unwrap_or(a),
                law::compliant_gap(a, b, c, d).unwrap_or(b),
            ],
        });
        let scene = kernel.scene_mut();
        let _ = black_box(scene.set_mass(&black_box(SMatrix::identity())));
        let _ = black_box(scene.push_on(&contact, &surface));
        for joint in [
            law::joint_limit(row, a, b, c.abs(), d.abs(), 0),
            law::dry_friction(row, a, b, 1),
            law::motor(row, &gains, a, b, c, 2),
            law::closed_loop(row, a, b, 1.0, 3),
        ] {
            let joint = match joint {
                Ok(joint) => joint,
                Err(error) => {
                    let _ = write!(Sink, "{error}");
                    continue;
                }
            };
            if let Ok(index) = black_box(scene.push_row(&joint)) {
                let _ = black_box(scene.set_row_offset(index, black_box(a)));
                let _ = black_box(scene.set_row_law(index, joint.law));
            }
        }
        let (push, settings) = (black_box(row), black_box(Settings::default()));
        let _ = black_box(kernel.solve(&push, &settings).is_ok());
        let _ = black_box(kernel.resume(&push, &settings).is_ok());
        let limits = black_box([
            law::joint_limit(row, a, b, c, d, 4),
            law::joint_limit(-row, b, a, c, d, 5),
        ]);
        if let [Ok(lower), Ok(upper)] = limits {
            let limits = [lower, upper];
            let _ = black_box(kernel.solve_with_limits(&limits, &push, &settings).is_ok());
        }
        let _ = black_box(kernel.solution().row_by_key(black_box(4)));
        let index = black_box(stiction::RowIndex { slot: 1, row: 2 });
        let _ = black_box(kernel.solution().row(index));
        kernel.scene_mut().clear_contacts();
    }

    #[entry]
    fn main() -> ! {
        static mut MIXED: Mixed = Mixed::mixed();
        static mut QUADRUPED: Bench<f32, 18, 3, 4> = Bench::new();
        static mut STACK: Bench<f32, 18, 3, 12> = Bench::new();
        static mut WALKER: Bench<f32, 9, 2, 4> = Bench::new();
        static mut FRICTIONLESS: Bench<f64, 6, 1, 4> = Bench::new();
        QUADRUPED.call();
        STACK.call();
        WALKER.call();
        FRICTIONLESS.call();
        call_mixed(MIXED);
        loop {
            debug::exit(debug::EXIT_SUCCESS);
        }
    }
}
