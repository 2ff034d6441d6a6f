//! The state of a simulation, and what MuJoCo does with it.

use super::model::Sizes;
use super::{Address, Library, Model, array, read};
use std::sync::Arc;

/// An `mjData`, of the user or a scratch of the Stepper.
pub(in super::super) struct Data {
    library: Arc<Library>,
    at: Address,
    sizes: Sizes,
    is_own: bool,
}

// SAFETY: one Stepper at a time steps it.
unsafe impl Send for Data {}
// SAFETY: nothing is written through a shared reference, but by functions of MuJoCo that take one.
unsafe impl Sync for Data {}

macro_rules! arrays {
    ($($name:ident, $mutable:ident: $t:ty, $count:expr;)*) => {
        impl Data {
            $(#[allow(dead_code)] // some are only written
            pub(in super::super) fn $name(&self) -> &[$t] {
                // SAFETY: MuJoCo's header gives type and size.
                unsafe { array(self.at, self.library.layout.data.$name, $count(self)) }
            }

            #[allow(dead_code)] // some are only read
            pub(in super::super) fn $mutable(&mut self) -> &mut [$t] {
                let count = $count(self);
                if count == 0 {
                    return &mut [];
                }
                // SAFETY: as above, and this has the only reference.
                unsafe {
                    let first = read::<*mut $t>(self.at, self.library.layout.data.$name);
                    std::slice::from_raw_parts_mut(first, count)
                }
            })*
        }
    };
}

arrays! {
    qpos, qpos_mut: f64, |own: &Self| own.sizes.positions;
    qvel, qvel_mut: f64, |own: &Self| own.sizes.velocities;
    ctrl, ctrl_mut: f64, |own: &Self| own.sizes.controls;
    sensordata, sensordata_mut: f64, |own: &Self| own.sizes.readings;
    mocap_pos, mocap_pos_mut: [f64; 3], |own: &Self| own.sizes.mocaps;
    mocap_quat, mocap_quat_mut: [f64; 4], |own: &Self| own.sizes.mocaps;
    qacc, qacc_mut: f64, |own: &Self| own.sizes.velocities;
    qfrc_smooth, qfrc_smooth_mut: f64, |own: &Self| own.sizes.velocities;
    qfrc_constraint, qfrc_constraint_mut: f64, |own: &Self| own.sizes.velocities;
    ten_velocity, ten_velocity_mut: f64, |own: &Self| own.sizes.tendons;
    geom_xpos, geom_xpos_mut: [f64; 3], |own: &Self| own.sizes.geoms;
    geom_xmat, geom_xmat_mut: [f64; 9], |own: &Self| own.sizes.geoms;
    efc_type, efc_type_mut: i32, Self::constraints;
    efc_id, efc_id_mut: i32, Self::constraints;
    efc_pos, efc_pos_mut: f64, Self::constraints;
    efc_frictionloss, efc_frictionloss_mut: f64, Self::constraints;
    efc_kbip, efc_kbip_mut: [f64; 4], Self::constraints;
    efc_force, efc_force_mut: f64, Self::constraints;
    efc_j, efc_j_mut: f64, |own: &Self| own.constraints() * own.sizes.velocities;
}

/// `exclude` of a contact that moves nothing.
const LEFT_OUT: i32 = 3;

/// A contact of MuJoCo's list.
#[derive(Clone, Copy)]
pub(in super::super) struct ContactRef<'a> {
    data: &'a Data,
    at: *const u8,
}

impl ContactRef<'_> {
    fn of<T: Copy>(self, offset: usize) -> T {
        // SAFETY: the offsets that are asked for have these types in MuJoCo's header.
        unsafe { read(self.at, offset) }
    }

    /// Distance (m) behind MuJoCo's margin, of which `grown` is not the user's.
    pub(in super::super) fn gap(self, grown: f64) -> f64 {
        let layout = &self.data.library.layout.contact;
        self.of::<f64>(layout.dist) - (self.of::<f64>(layout.includemargin) - grown)
    }

    pub(in super::super) fn place(self) -> [f64; 3] {
        self.of(self.data.library.layout.contact.pos)
    }

    /// Normal and tangents, from the first geom to the second.
    pub(in super::super) fn frame(self) -> [[f64; 3]; 3] {
        self.of(self.data.library.layout.contact.frame)
    }

    pub(in super::super) fn solref(self) -> [f64; 2] {
        self.of(self.data.library.layout.contact.solref)
    }

    pub(in super::super) fn friction(self) -> [f64; 5] {
        self.of(self.data.library.layout.contact.friction)
    }

    /// Before 4.0 no surface moves.
    pub(in super::super) fn surface_velocity(self) -> [f64; 3] {
        self.data.library.layout.contact.surfacevel.map_or([0.0; 3], |offset| self.of(offset))
    }

    pub(in super::super) fn dim(self) -> usize {
        self.of::<i32>(self.data.library.layout.contact.dim).unsigned_abs() as usize
    }

    /// Its two geoms. (There are no flexes.)
    pub(in super::super) fn geoms(self) -> [usize; 2] {
        let geoms: [i32; 2] = self.of(self.data.library.layout.contact.geom);
        geoms.map(|geom| geom.unsigned_abs() as usize)
    }

    pub(in super::super) fn is_excluded(self) -> bool {
        self.of::<i32>(self.data.library.layout.contact.exclude) != 0
    }

    /// Its first row among the constraints, if it has any.
    pub(in super::super) fn address(self) -> Option<usize> {
        usize::try_from(self.of::<i32>(self.data.library.layout.contact.efc_address)).ok()
    }
}

impl Data {
    /// # Safety
    /// There is an `mjData` of the model's library at `address`, as long as this lives.
    ///
    /// # Errors
    /// It belongs to another model.
    pub(in super::super) unsafe fn new(model: &Model, address: usize) -> Result<Self, &'static str> {
        let own = Self {
            library: Arc::clone(&model.library),
            at: address as Address,
            sizes: model.sizes,
            is_own: false,
        };
        // SAFETY: as MuJoCo's header says.
        let signature =
            own.library.layout.data.signature.map(|offset| unsafe { read::<u64>(own.at, offset) });
        let is_its_own = signature == model.signature() && model.shape.get() == Some(&own.shape());
        is_its_own.then_some(own).ok_or("data: of another model")
    }

    /// How many bytes its arrays take, and where among these they are: the same of all data of a model.
    fn shape(&self) -> Vec<usize> {
        let layout = &self.library.layout.data;
        // SAFETY: as MuJoCo's header says.
        let of = |offset: usize| unsafe { read::<usize>(self.at, offset) };
        let (bytes, first) = (of(layout.nbuffer), of(layout.buffer));
        let arrays = [
            layout.qpos,
            layout.qvel,
            layout.ctrl,
            layout.sensordata,
            layout.mocap_pos,
            layout.mocap_quat,
            layout.qacc,
            layout.qderiv,
            layout.qfrc_smooth,
            layout.qfrc_constraint,
            layout.ten_velocity,
            layout.geom_xpos,
            layout.geom_xmat,
        ];
        let places = arrays.map(|array| of(array).wrapping_sub(first));
        places.into_iter().chain([bytes]).collect()
    }

    /// New data of a model.
    pub(in super::super) fn scratch(model: &Model) -> Self {
        // SAFETY: `mj_makeData` reads the model.
        let at = unsafe { (model.library.functions.make_data)(model.address()) };
        assert!(!at.is_null(), "MuJoCo has no memory for another mjData");
        let own = Self { library: Arc::clone(&model.library), at, sizes: model.sizes, is_own: true };
        model.shape.get_or_init(|| own.shape());
        own
    }

    /// Takes over another's state and results.
    pub(in super::super) fn copy_from(&mut self, model: &Model, other: &Self) {
        // SAFETY: both belong to the model.
        unsafe { (self.library.functions.copy_data)(self.at, model.address(), other.at) };
    }

    /// Sets the state that an `mjtState` names, and forgets all else.
    pub(in super::super) fn set_state(&mut self, model: &Model, state: &[f64], kind: i32) {
        // SAFETY: those who ask have the state's size from MuJoCo.
        unsafe {
            (self.library.functions.reset_data)(model.address(), self.at);
            (self.library.functions.set_state)(model.address(), self.at, state.as_ptr(), kind);
        }
    }

    /// Writes the state that an `mjtState` names.
    pub(in super::super) fn state(&self, model: &Model, state: &mut [f64], kind: i32) {
        // SAFETY: as above.
        unsafe {
            (self.library.functions.get_state)(model.address(), self.at, state.as_mut_ptr(), kind);
        }
    }

    /// Takes over another's positions and poses of motion capture.
    pub(in super::super) fn copy_pose(&mut self, other: &Self) {
        self.qpos_mut().copy_from_slice(other.qpos());
        self.mocap_pos_mut().copy_from_slice(other.mocap_pos());
        self.mocap_quat_mut().copy_from_slice(other.mocap_quat());
    }

    /// Where it is: the same data has the same place.
    pub(in super::super) fn place(&self) -> usize {
        self.at as usize
    }

    /// Time of the simulation (s).
    pub(in super::super) fn time(&self) -> f64 {
        // SAFETY: as MuJoCo's header says.
        unsafe { read(self.at, self.library.layout.data.time) }
    }

    fn count(&self, offset: usize) -> usize {
        // SAFETY: the offsets that are asked for are those of an `int`.
        unsafe { read::<i32>(self.at, offset) }.unsigned_abs() as usize
    }

    /// How many constraints MuJoCo lists.
    pub(in super::super) fn constraints(&self) -> usize {
        self.count(self.library.layout.data.nefc)
    }

    pub(in super::super) fn contacts(&self) -> impl ExactSizeIterator<Item = ContactRef<'_>> {
        (0..self.count(self.library.layout.data.ncon)).map(|index| self.contact(index))
    }

    pub(in super::super) fn contact(&self, index: usize) -> ContactRef<'_> {
        let layout = self.library.layout;
        // SAFETY: MuJoCo has that many contacts; those who ask have counted them.
        let at = unsafe { read::<*const u8>(self.at, layout.data.contact).add(index * layout.contact.size) };
        ContactRef { data: self, at }
    }

    /// Writes the distance of a contact.
    pub(in super::super) fn set_distance(&mut self, index: usize, distance: f64) {
        let at = self.contact(index).at.cast_mut();
        // SAFETY: as in `contact`.
        unsafe {
            at.add(self.library.layout.contact.dist).cast::<f64>().write_unaligned(distance);
        }
    }

    /// Computes how actuators push again. Those that pull at what their body touches do so at the contacts that `bear`, by their places.
    pub(in super::super) fn transmission(&mut self, model: &Model, bear: impl Fn(usize) -> bool) {
        let exclude = self.library.layout.contact.exclude;
        let others: Vec<_> = (0..self.contacts().len())
            .filter(|&index| !self.contact(index).is_excluded() && !bear(index))
            .map(|index| self.contact(index).at.cast_mut())
            .collect();
        // SAFETY: as in `contact`; model and data belong to each other.
        unsafe {
            let mark =
                |mark: i32| others.iter().for_each(|at| at.add(exclude).cast::<i32>().write_unaligned(mark));
            mark(LEFT_OUT);
            (self.library.functions.transmission)(model.address(), self.at);
            mark(0);
        }
    }

    /// Sensors of accelerations and forces, by those of this step: MuJoCo keeps the accelerations of bodies until it is told that they are old.
    pub(in super::super) fn sensor_acc(&mut self, model: &Model) {
        // SAFETY: MuJoCo's header gives the type; model and data belong to each other.
        unsafe {
            if let Some(flag) = self.library.layout.data.flg_rnepost {
                self.at.add(flag).write(0);
            }
            (self.library.functions.sensor_acc)(model.address(), self.at);
        }
    }

    /// Writes a contact in place of one of the list; its constraints stay where they are.
    pub(in super::super) fn replace_contact(&mut self, index: usize, other: &OwnedContact) {
        let layout = &self.library.layout.contact;
        let at = self.contact(index).at.cast_mut();
        // SAFETY: both have the size of a contact.
        unsafe {
            let address: i32 = read(at, layout.efc_address);
            at.copy_from_nonoverlapping(other.0.as_ptr().cast(), layout.size);
            at.add(layout.efc_address).cast::<i32>().write_unaligned(address);
        }
    }

    /// Adds a contact of other data to the list. Returns its place; `None` if there is no room.
    pub(in super::super) fn add_contact(&mut self, model: &Model, other: &OwnedContact) -> Option<usize> {
        let place = self.contacts().len();
        let at = other.0.as_ptr().cast_mut().cast();
        // SAFETY: MuJoCo copies the contact.
        let is_full = unsafe { (self.library.functions.add_contact)(model.address(), self.at, at) } != 0;
        (!is_full).then_some(place)
    }

    /// The derivative of smooth forces by velocity, without that of Coriolis forces: row, column and entry.
    pub(in super::super) fn velocity_derivative(
        &mut self,
        model: &Model,
    ) -> impl Iterator<Item = (usize, usize, f64)> {
        let (own, of_model, n) =
            (&self.library.layout.data, &self.library.layout.model, self.sizes.velocities);
        // Before 3.3.6 the data says which entries there are.
        let place = |in_model: Option<usize>, in_data: Option<usize>| {
            let of_model = in_model.map(|offset| (model.original(), offset));
            of_model.or(in_data.map(|offset| (self.at.cast_const(), offset)))
        };
        let places = [
            place(of_model.d_rownnz, own.d_rownnz),
            place(of_model.d_rowadr, own.d_rowadr),
            place(of_model.d_colind, own.d_colind),
        ];
        let [counts, firsts, columns] =
            places.map(|place| place.unwrap_or_else(|| unreachable!("each version has them")));
        // SAFETY: MuJoCo's header gives types and sizes, and `qDeriv` has an entry for each column.
        let (counts, firsts, columns, entries) = unsafe {
            (self.library.functions.smooth_velocity)(model.address(), self.at, 0);
            let counts: &[i32] = array(counts.0, counts.1, n);
            let firsts: &[i32] = array(firsts.0, firsts.1, n);
            let all =
                n.checked_sub(1).map_or(0, |last| (firsts[last] + counts[last]).unsigned_abs() as usize);
            (counts, firsts, array::<i32>(columns.0, columns.1, all), array::<f64>(self.at, own.qderiv, all))
        };
        counts.iter().zip(firsts).enumerate().flat_map(move |(row, (count, first))| {
            let first = first.unsigned_abs() as usize;
            (first..first + count.unsigned_abs() as usize)
                .map(move |place| (row, columns[place].unsigned_abs() as usize, entries[place]))
        })
    }

    /// Writes the mass matrix, row by row.
    pub(in super::super) fn mass(&self, model: &Model, mass: &mut Vec<f64>) {
        mass.resize(self.sizes.velocities * self.sizes.velocities, 0.0);
        let full: Address = mass.as_mut_ptr().cast();
        let layout = self.library.layout;
        // SAFETY: there is room for it; before 3.10 the function takes the matrix of the data behind what it fills.
        unsafe {
            let [second, third] = match layout.data.qm {
                Some(offset) if !layout.mass_of_data => [full, read(self.at, offset)],
                _ => [self.at, full],
            };
            (self.library.functions.full_mass)(model.address(), second, third);
        }
    }

    /// Jacobians (three rows each) of a point of a body, and of its rotation.
    pub(in super::super) fn jacobian(&self, model: &Model, place: [f64; 3], body: usize) -> [Vec<f64>; 2] {
        let mut rows = [(); 2].map(|()| vec![0.0; 3 * self.sizes.velocities]);
        let [point, turn] = rows.each_mut().map(Vec::as_mut_ptr);
        let body = i32::try_from(body).unwrap_or(0);
        // SAFETY: there is room for both.
        unsafe {
            (self.library.functions.jacobian)(model.address(), self.at, point, turn, place.as_ptr(), body);
        }
        rows
    }
}

macro_rules! stages {
    ($($(#[$doc:meta])* $name:ident;)*) => {
        impl Data {
            $($(#[$doc])*
            pub(in super::super) fn $name(&mut self, model: &Model) {
                // SAFETY: model and data belong to each other.
                unsafe { (self.library.functions.$name)(model.address(), self.at) };
            })*
        }
    };
}

stages! {
    /// Positions, collision, constraints, velocities and their sensors.
    step1;
    actuation;
    acceleration;
    kinematics;
    com_pos;
    collision;
    make_constraint;
    /// Starts anew from what is not finite, or huge.
    check_acceleration;
    /// Velocities by `qacc`, positions by the new velocities.
    euler;
}

/// A copy of a contact.
pub(in super::super) struct OwnedContact(Box<[u64]>);

impl OwnedContact {
    /// Copies it with a distance of at most `most` and a margin that is `less`.
    pub(in super::super) fn new(contact: ContactRef<'_>, most: f64, less: f64) -> Self {
        let layout = &contact.data.library.layout.contact;
        let mut copy = vec![0_u64; layout.size.div_ceil(8)].into_boxed_slice();
        let margin = contact.of::<f64>(layout.includemargin) - less;
        let distance = contact.of::<f64>(layout.dist).min(most);
        // SAFETY: a contact has that size, and these fields.
        unsafe {
            let at = copy.as_mut_ptr().cast::<u8>();
            at.copy_from_nonoverlapping(contact.at, layout.size);
            at.add(layout.dist).cast::<f64>().write_unaligned(distance);
            at.add(layout.includemargin).cast::<f64>().write_unaligned(margin);
        }
        Self(copy)
    }
}

impl Model {
    /// `positions` after `time` (s) at these velocities.
    pub(in super::super) fn integrate(&self, positions: &mut [f64], velocities: &[f64], time: f64) {
        // SAFETY: both have the model's sizes.
        unsafe {
            (self.library.functions.integrate)(
                self.address(),
                positions.as_mut_ptr(),
                velocities.as_ptr(),
                time,
            );
        }
    }

    /// What leads from positions to others in a time of 1.
    pub(in super::super) fn difference(&self, from: &[f64], to: &[f64], velocities: &mut [f64]) {
        // SAFETY: all have the model's sizes.
        unsafe {
            (self.library.functions.differentiate)(
                self.address(),
                velocities.as_mut_ptr(),
                1.0,
                from.as_ptr(),
                to.as_ptr(),
            );
        }
    }
}

impl Drop for Data {
    fn drop(&mut self) {
        if self.is_own {
            // SAFETY: `scratch` has made it, and nobody else has it.
            unsafe { (self.library.functions.delete_data)(self.at) };
        }
    }
}
