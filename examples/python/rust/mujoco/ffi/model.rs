//! A model as the Stepper needs it: the arrays are those of the user, options and margins its own.

use super::{Address, DENSE, ELLIPTIC, EULER, IMPLICITFAST, Library, array, read};
use std::sync::{Arc, OnceLock};

/// Sizes of a model.
#[derive(Clone, Copy)]
pub(in super::super) struct Sizes {
    pub(in super::super) positions: usize,
    pub(in super::super) velocities: usize,
    pub(in super::super) bodies: usize,
    pub(in super::super) joints: usize,
    pub(in super::super) geoms: usize,
    pub(in super::super) mocaps: usize,
    pub(in super::super) equalities: usize,
    pub(in super::super) tendons: usize,
    pub(in super::super) actuators: usize,
    pub(in super::super) controls: usize,
    pub(in super::super) readings: usize,
    pairs: usize,
}

/// From this version on the margins of two geoms add up; before, the larger counted. (No header says so.)
const MARGINS_ADD: i32 = 3_005_000;

/// A copy of the struct `mjModel`, not of what it points to: what the user changes in an array is seen, and what is set here is not
/// seen by the user, nor by others who step the same model.
pub(in super::super) struct Model {
    pub(super) library: Arc<Library>,
    original: *const u8,
    copy: Box<[u64]>,
    pub(in super::super) sizes: Sizes,
    /// Margins of geoms, bodies, pairs, joints and tendons.
    margins: [Vec<f64>; 5],
    /// What its data has in memory: see `Data::shape`.
    pub(super) shape: OnceLock<Vec<usize>>,
}

// SAFETY: the model is only read, and Python keeps it alive as long as its Stepper.
unsafe impl Send for Model {}
// SAFETY: as above.
unsafe impl Sync for Model {}

macro_rules! arrays {
    ($($name:ident: $t:ty, $size:ident * $times:literal;)*) => {
        impl Model {
            $(pub(in super::super) fn $name(&self) -> &[$t] {
                // SAFETY: MuJoCo's header gives type and size.
                unsafe { array(self.original, self.library.layout.model.$name, self.sizes.$size * $times) }
            })*
        }
    };
}

arrays! {
    body_parentid: i32, bodies * 1;
    body_weldid: i32, bodies * 1;
    body_mocapid: i32, bodies * 1;
    body_invweight0: f64, bodies * 2;
    jnt_type: i32, joints * 1;
    jnt_dofadr: i32, joints * 1;
    dof_treeid: i32, velocities * 1;
    dof_damping: f64, velocities * 1;
    dof_invweight0: f64, velocities * 1;
    geom_type: i32, geoms * 1;
    geom_contype: i32, geoms * 1;
    geom_conaffinity: i32, geoms * 1;
    geom_bodyid: i32, geoms * 1;
    geom_dataid: i32, geoms * 1;
    geom_rbound: f64, geoms * 1;
    geom_aabb: f64, geoms * 6;
    eq_type: i32, equalities * 1;
    eq_obj1id: i32, equalities * 1;
    eq_obj2id: i32, equalities * 1;
    eq_objtype: i32, equalities * 1;
    actuator_trntype: i32, actuators * 1;
    eq_solref: [f64; 2], equalities * 1;
    tendon_invweight0: f64, tendons * 1;
    jnt_margin: f64, joints * 1;
    tendon_margin: f64, tendons * 1;
    geom_margin: f64, geoms * 1;
    body_margin: f64, bodies * 1;
    pair_margin: f64, pairs * 1;
}

impl Model {
    /// # Safety
    /// There is an `mjModel` of the library at `address`, as long as this lives.
    pub(in super::super) unsafe fn new(library: Arc<Library>, address: usize) -> Self {
        let original = address as *const u8;
        let layout = &library.layout.model;
        // SAFETY: the caller's; sizes are `int` or `int64_t`.
        let size = |offset: usize| unsafe {
            let size = match library.layout.size_bytes {
                4 => i64::from(read::<i32>(original, offset)),
                _ => read::<i64>(original, offset),
            };
            usize::try_from(size).unwrap_or(0)
        };
        let sizes = Sizes {
            positions: size(layout.nq),
            velocities: size(layout.nv),
            bodies: size(layout.nbody),
            joints: size(layout.njnt),
            geoms: size(layout.ngeom),
            mocaps: size(layout.nmocap),
            equalities: size(layout.neq),
            tendons: size(layout.ntendon),
            // Earlier versions have one control for each.
            actuators: size(layout.nactuator.unwrap_or(layout.nu)),
            controls: size(layout.nu),
            readings: size(layout.nsensordata),
            pairs: size(layout.npair),
        };
        let counts = [sizes.geoms, sizes.bodies, sizes.pairs, sizes.joints, sizes.tendons];
        let copy = vec![0; layout.size.div_ceil(8)].into_boxed_slice();
        let margins = counts.map(|count| vec![0.0; count]);
        let mut own = Self { original, copy, sizes, margins, shape: OnceLock::new(), library };
        own.refresh();
        own
    }

    /// Takes options and pointers as they are now, and what the Stepper needs in their place.
    pub(in super::super) fn refresh(&mut self) {
        let own = self.library.layout;
        let layout = &own.model;
        let (tolerance, iterations) = (1e-12 * self.size(), 200_i32);
        // Damping is in the matrix of the solver, which has islands of its own.
        let disabled = self.disabled() | own.euler_damping_off | own.islands_off;
        let enabled = self.of::<i32>(layout.opt_enableflags) & !own.islands_on;
        // SAFETY: both are an `mjModel`, and what is written is what its header has there.
        unsafe {
            let copy = self.copy.as_mut_ptr().cast::<u8>();
            copy.copy_from_nonoverlapping(self.original, layout.size);
            copy.add(layout.opt_disableflags).cast::<i32>().write_unaligned(disabled);
            copy.add(layout.opt_enableflags).cast::<i32>().write_unaligned(enabled);
            copy.add(layout.opt_cone).cast::<i32>().write_unaligned(ELLIPTIC);
            copy.add(layout.opt_jacobian).cast::<i32>().write_unaligned(DENSE);
            copy.add(layout.opt_ccd_tolerance).cast::<f64>().write_unaligned(tolerance);
            copy.add(layout.opt_ccd_iterations).cast::<i32>().write_unaligned(iterations);
            if self.integrator() != EULER {
                copy.add(layout.opt_integrator).cast::<i32>().write_unaligned(IMPLICITFAST);
            }
            let places = [
                layout.geom_margin,
                layout.body_margin,
                layout.pair_margin,
                layout.jnt_margin,
                layout.tendon_margin,
            ];
            for (margins, place) in self.margins.iter_mut().zip(places) {
                copy.add(place).cast::<*mut f64>().write_unaligned(margins.as_mut_ptr());
            }
        }
    }

    /// Sets margins to those of the user and a little more: of contacts, and of limits of joints and of tendons.
    pub(in super::super) fn grow_margins(&mut self, contacts: f64, limits: [f64; 2]) {
        let mut margins = std::mem::take(&mut self.margins);
        let [geoms, bodies, pairs, joints, tendons] = &mut margins;
        let of_each = if self.library.version < MARGINS_ADD { contacts } else { 0.5 * contacts };
        for (margins, own, more) in [
            (geoms, self.geom_margin(), of_each),
            (bodies, self.body_margin(), of_each),
            (pairs, self.pair_margin(), contacts),
            (joints, self.jnt_margin(), limits[0]),
            (tendons, self.tendon_margin(), limits[1]),
        ] {
            margins.iter_mut().zip(own).for_each(|(margin, own)| *margin = own + more);
        }
        self.margins = margins; // moved, so their places are as before
    }

    /// See [`Library::watched`].
    pub(in super::super) fn library(&self) -> Arc<Library> {
        Arc::clone(&self.library)
    }

    pub(super) fn address(&self) -> Address {
        self.copy.as_ptr().cast_mut().cast()
    }

    /// Names what it was compiled from; versions before 3.3.1 have none.
    pub(super) fn signature(&self) -> Option<u64> {
        self.library.layout.model.signature.map(|offset| self.of(offset))
    }

    fn of<T: Copy>(&self, offset: usize) -> T {
        // SAFETY: the offsets that are asked for have these types in MuJoCo's header.
        unsafe { read(self.original, offset) }
    }

    /// Time step (s).
    pub(in super::super) fn step(&self) -> f64 {
        self.of(self.library.layout.model.opt_timestep)
    }

    pub(in super::super) fn gravity(&self) -> [f64; 3] {
        self.of(self.library.layout.model.opt_gravity)
    }

    pub(in super::super) fn integrator(&self) -> i32 {
        self.of(self.library.layout.model.opt_integrator)
    }

    fn disabled(&self) -> i32 {
        self.of(self.library.layout.model.opt_disableflags)
    }

    /// Is damping of joints implicit?
    pub(in super::super) fn damps(&self) -> bool {
        self.disabled() & (self.library.layout.euler_damping_off | self.library.layout.damper_off) == 0
    }

    /// The mean size of its bodies (m): what is small beside it is small.
    pub(in super::super) fn size(&self) -> f64 {
        self.of(self.library.layout.model.stat_meansize)
    }

    pub(super) fn original(&self) -> *const u8 {
        self.original
    }

    /// Body of a site.
    pub(in super::super) fn site_body(&self, site: usize) -> usize {
        // SAFETY: MuJoCo has checked the site.
        let bodies: &[i32] = unsafe { array(self.original, self.library.layout.model.site_bodyid, site + 1) };
        bodies[site].unsigned_abs() as usize
    }

    /// Scale of the rotation of a weld (m).
    pub(in super::super) fn weld_scale(&self, equality: usize) -> f64 {
        let width = self.library.layout.equality_data;
        // SAFETY: MuJoCo's header gives type and size.
        let data: &[f64] =
            unsafe { array(self.original, self.library.layout.model.eq_data, width * self.sizes.equalities) };
        data[width * equality + 10]
    }

    /// Size (x, y, top, bottom) of a height field, its heights from 0 to 1, rows and columns.
    pub(in super::super) fn height_field(&self, field: usize) -> ([f64; 4], &[f32], [usize; 2]) {
        let layout = &self.library.layout.model;
        // SAFETY: MuJoCo's header gives types and sizes, and MuJoCo has checked the field.
        unsafe {
            let sizes: &[[f64; 4]] = array(self.original, layout.hfield_size, field + 1);
            let of = |offset| array::<i32>(self.original, offset, field + 1)[field].unsigned_abs() as usize;
            let [rows, columns, first] = [layout.hfield_nrow, layout.hfield_ncol, layout.hfield_adr].map(of);
            let heights: &[f32] = array(self.original, layout.hfield_data, first + rows * columns);
            (sizes[field], &heights[first..], [rows, columns])
        }
    }
}
