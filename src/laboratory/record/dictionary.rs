//! The dictionary: unit and meaning of every column of every table that runs leave. `comminute check --columns` prints it, and
//! the book has it as a page.

/// A column of a table.
#[derive(Clone, Copy, Debug)]
pub struct Column {
    /// Name, as in the header.
    pub name: &'static str,
    /// Unit; `-` for a number without a unit, a text or a count.
    pub unit: &'static str,
    /// Meaning.
    pub what: &'static str,
}

/// A table, or several tables with the same columns.
#[derive(Clone, Copy, Debug)]
pub struct Sheet {
    /// Names of the files, with commas between.
    pub files: &'static str,
    /// Kinds of scenes whose runs leave the table, with commas between; or the command that leaves it.
    pub of: &'static str,
    /// The columns, in the order of the table.
    pub columns: &'static [Column],
}

impl Sheet {
    /// Whether this is the table `file` of a run of a scene of kind `kind`.
    pub fn describes(&self, file: &str, kind: &str) -> bool {
        self.files.split(", ").any(|f| f == file) && self.of.split(", ").any(|k| k == kind)
    }
}

const fn column(name: &'static str, unit: &'static str, what: &'static str) -> Column {
    Column { name, unit, what }
}

/// The dictionary.
pub const SHEETS: &[Sheet] = &[
    Sheet { files: "history.csv", of: "oedometer, triaxial, isotropic", columns: SPECIMEN_HISTORY },
    Sheet { files: "history.csv", of: "assembly", columns: FREE_HISTORY },
    Sheet { files: "history.csv", of: "continuum, mixture", columns: CONTINUUM_HISTORY },
    Sheet { files: "gsd.csv", of: "oedometer, triaxial, isotropic, mixture", columns: GSD },
    Sheet { files: "breakage.csv", of: "oedometer, triaxial, isotropic, assembly, mixture", columns: BREAKAGE },
    Sheet { files: "contacts_*.csv", of: "oedometer, triaxial, isotropic, assembly, mixture", columns: CONTACTS },
    Sheet { files: "tracks.csv", of: "assembly", columns: TRACKS },
    Sheet { files: "blocks.csv", of: "mixture", columns: BLOCKS },
    Sheet { files: "joints.csv", of: "mixture", columns: JOINTS },
    Sheet { files: "block_surfaces.csv", of: "mixture", columns: BLOCK_SURFACES },
    Sheet { files: "block_breakage.csv", of: "mixture", columns: BLOCK_BREAKAGE },
    Sheet { files: "walls.csv", of: "mixture", columns: WALLS },
    Sheet { files: "account.csv", of: "continuum, mixture", columns: ACCOUNT },
    Sheet { files: "specimen.csv, grains_start.csv", of: "oedometer, triaxial, isotropic, assembly, mixture", columns: SPECIMEN },
    Sheet { files: "grains_final.csv", of: "oedometer, triaxial, isotropic, assembly, mixture", columns: GRAINS_FINAL },
    Sheet { files: "points_start.csv, points_final.csv", of: "continuum, mixture", columns: POINTS },
    Sheet { files: "platen.csv", of: "platen", columns: PLATEN },
    Sheet { files: "force_displacement.csv", of: "platen", columns: FORCE_DISPLACEMENT },
    Sheet { files: "survival.csv", of: "platen", columns: SURVIVAL },
    Sheet { files: "limit_force.csv", of: "platen", columns: LIMITS },
    Sheet { files: "sweep.csv", of: "comminute sweep, with a column for each key that is varied", columns: SWEEP },
    Sheet { files: "study.csv", of: "comminute study", columns: STUDY },
    Sheet { files: "effects.csv", of: "comminute study, of a factorial", columns: EFFECTS },
    Sheet {
        files: "mean.csv",
        of: "comminute ensemble, with _mean, _sd, _low and _high of every column of history.csv",
        columns: MEAN,
    },
    Sheet { files: "runs.csv", of: "comminute plot and reproduce", columns: RUNS },
];

const SPECIMEN_HISTORY: &[Column] = &[
    column("step", "-", "steps since the start of the test"),
    column("stage", "-", "what the test does: settle, load, unload, reload (oedometer), or shear (triaxial)"),
    column(
        "target_kPa",
        "kPa",
        "stress that the platens (oedometer: vertical) or the cylinder (triaxial: cell pressure) are to hold now",
    ),
    column("sigma_v_kPa", "kPa", "vertical stress: mean of both platens' forces over the present area"),
    column("sigma_h_kPa", "kPa", "horizontal stress: force on the cylinder over its present area"),
    column("k0", "-", "oedometer: sigma_h over sigma_v"),
    column("radial_strain", "-", "triaxial: shortening of the radius over that at the start of shear"),
    column(
        "volumetric_strain",
        "-",
        "triaxial: loss of volume between the walls over that at the start of shear, compression positive",
    ),
    column("diameter_mm", "mm", "triaxial: diameter of the cylinder"),
    column("stress_ratio", "-", "triaxial: q over p"),
    column("friction_angle_deg", "°", "triaxial: mobilised friction angle, asin((sigma_v - sigma_h) / (sigma_v + sigma_h))"),
    column("q_kPa", "kPa", "deviatoric stress, sigma_v - sigma_h"),
    column("p_kPa", "kPa", "mean stress, (sigma_v + 2 sigma_h) / 3"),
    column("axial_strain", "-", "loss of height over the height at the start of the test, compression positive"),
    column("height_mm", "mm", "distance of the platens"),
    column(
        "porosity",
        "-",
        "pores over the volume between the walls; all dry mass is solid, what breakages have lost too: a laboratory's porosity",
    ),
    column("void_ratio", "-", "porosity / (1 - porosity): a laboratory's void ratio"),
    column("porosity_grains", "-", "porosity where only grains that survive are solid, and what breakages have lost is pores"),
    column("void_ratio_grains", "-", "the same as a void ratio"),
    column("porosity_star", "-", "porosity with the pores inside the grains, 1 - (1 - n)(1 - n_int) (Ciantia et al. 2015, eq. 20)"),
    column("void_ratio_star", "-", "the same as a void ratio"),
    column("platen_difference", "-", "difference of the two platens' stresses over their mean; small is quasi-static"),
    column("coordination_number", "-", "twice the contacts over the grains"),
    column(
        "coordination_number_no_rattlers",
        "-",
        "the same without grains of fewer than two contacts, and without their contacts",
    ),
    column("fabric_zz", "-", "share of contact normals along the vertical: mean of n_z^2; 1/3 is isotropic"),
    column("rattlers", "-", "grains with no contact or one"),
    column("unbalanced_ratio", "-", "mean resultant force on a grain over the mean contact force; small is in balance"),
    column(
        "inertial_number",
        "-",
        "strain rate of the platen times d sqrt(rho / sigma_v), with the inertia used; below 0.001 is quasi-static",
    ),
    column("grains", "-", "grains now"),
    column("crush_events", "-", "breakages so far"),
    column(
        "love_weber_sigma_v_kPa",
        "kPa",
        "vertical stress from contact forces in the inner 80 % (Love-Weber), to compare with the platens'",
    ),
    column("love_weber_sigma_h_kPa", "kPa", "horizontal stress from the same"),
    column("overlap_fraction", "-", "volume of all overlaps over that of the grains; large is beyond the contact law"),
    column("largest_overlap_ratio", "-", "largest overlap of a contact over the smaller radius"),
    column("mass_grains_kg", "kg", "mass of the grains"),
    column("mass_lost_kg", "kg", "mass that breakages have lost so far (dust that is no grain any more)"),
    column("mass_error", "-", "mass of grains and lost mass less that at the start, over it; rounding only"),
    column("d10_mm", "mm", "size below which 10 % of the mass is, lost mass restored (eq. 12), scale taken out"),
    column("d30_mm", "mm", "the same for 30 %"),
    column("d50_mm", "mm", "the same for 50 %: the median"),
    column("d60_mm", "mm", "the same for 60 %"),
    column("cu", "-", "uniformity, d60 / d10"),
    column("cc", "-", "curvature, d30^2 / (d10 d60)"),
    column("hardin_br", "-", "relative breakage of Hardin (1985): 0 none"),
    column("einav_br", "-", "relative breakage of Einav (2007), counted at each size up to the ultimate gradation: 0 none, 1 all"),
    column(
        "einav_beyond",
        "-",
        "what the gradation is finer than the ultimate one, over the same area; 0 while that is not passed",
    ),
    column("energy_wall_J", "J", "work that the walls have done on grains and on points from breakages"),
    column("energy_path_J", "J", "work of the contact forces along the grains' way"),
    column("energy_stored_J", "J", "elastic energy in the contacts"),
    column("energy_slip_J", "J", "lost in sliding contacts"),
    column("energy_viscous_J", "J", "lost in viscous contacts"),
    column("energy_damping_J", "J", "taken by local damping"),
    column("energy_kinetic_J", "J", "kinetic energy"),
    column("energy_lost_kinetic_J", "J", "kinetic energy of broken grains less that of their daughters"),
    column("energy_contacts_removed_J", "J", "elastic energy of contacts that went with broken grains"),
    column("energy_contacts_made_J", "J", "elastic energy of contacts that daughters were born with"),
    column("energy_inertia_J", "J", "kinetic energy that came from changes of scaled inertia"),
    column("energy_growth_J", "J", "work of daughters on their contacts while they grow to their size (crushing.birth)"),
    column("energy_release_J", "J", "work of broken grains' softening contacts on their neighbours (crushing.birth)"),
    column("energy_error", "-", "what the balance does not account for over the energy that went through"),
    column(
        "energy_nonconservative",
        "-",
        "work along the way that was neither stored nor lost in slip and viscosity, over the energy that went through",
    ),
    column("fines_points", "-", "oedometer with crushing.lost_mass = \"points\": points from breakages"),
    column("fines_mass_kg", "kg", "the same: their mass"),
    column("reserve_mass_kg", "kg", "the same: mass that waits for room"),
    column("sigma_v_points_kPa", "kPa", "the same: part of the vertical stress that points bear at the platens"),
    column("energy_points_J", "J", "the same: work of grains and walls on points"),
    column("released_J", "J", "the same: energy from overlaps that were let go"),
];

const FREE_HISTORY: &[Column] = &[
    column("step", "-", "steps since the start"),
    column("time_s", "s", "time"),
    column("grains", "-", "grains now"),
    column("crush_events", "-", "breakages so far"),
    column("coordination_number", "-", "twice the contacts over the grains"),
    column("unbalanced_ratio", "-", "mean resultant force on a grain over the mean contact force"),
    column("kinetic_energy_J", "J", "kinetic energy of the grains"),
    column("stored_energy_J", "J", "elastic energy in the contacts"),
    column("potential_energy_J", "J", "potential energy in gravity"),
    column("slip_work_J", "J", "lost in sliding contacts"),
    column("viscous_work_J", "J", "lost in viscous contacts"),
    column("damping_work_J", "J", "taken by local damping"),
    column("wall_work_J", "J", "work that the walls have done on grains and on points from breakages"),
    column("energy_error", "-", "what the balance does not account for over the energy that went through"),
    column(
        "energy_nonconservative",
        "-",
        "work of contacts that was neither stored nor lost in slip and viscosity, over the energy that went through",
    ),
    column("mass_grains_kg", "kg", "mass of the grains"),
    column("mass_lost_kg", "kg", "mass that breakages have lost so far"),
];

const CONTINUUM_HISTORY: &[Column] = &[
    column("step", "-", "steps of the continuum since the start"),
    column("time_s", "s", "time"),
    column("stage", "-", "settle, or load"),
    column("dt_s", "s", "time step"),
    column("front_mm", "mm", "free scene: how far the material reaches along x"),
    column("height_mm", "mm", "free scene: how high it reaches"),
    column("passed_kg", "kg", "mass whose centres are beyond the plane of records.gate_mm: of points, grains and rigid bodies"),
    column("axial_strain", "-", "test: axial strain since the start of loading, compression positive"),
    column("volumetric_strain", "-", "triaxial: loss of volume between the platens over that at the start, compression positive"),
    column("sigma_v_kPa", "kPa", "oedometer: vertical stress on the platens, a mean since the row before"),
    column("sigma_h_kPa", "kPa", "oedometer: lateral stress, a mean since the row before"),
    column("k0", "-", "oedometer: sigma_h over sigma_v"),
    column("sigma_1_kPa", "kPa", "triaxial: axial stress, a mean since the row before"),
    column("sigma_3_kPa", "kPa", "triaxial: lateral stress, a mean since the row before"),
    column("principal_ratio", "-", "triaxial: sigma_1 over sigma_3"),
    column("pore_pressure_kPa", "kPa", "triaxial at constant volume: equivalent pore pressure, cell pressure less lateral stress"),
    column("q_kPa", "kPa", "test: deviatoric stress"),
    column(
        "p_kPa",
        "kPa",
        "test: mean stress (sigma_1 + 2 sigma_3) / 3; in plane strain with the stress of the points across the plane as the third, without points (sigma_1 + sigma_3) / 2",
    ),
    column("platen_difference", "-", "test: largest difference of two opposite sides over their mean; small is quasi-static"),
    column(
        "void_ratio",
        "-",
        "pores over solids: of a mixture all of it, grains, points and what breakages have lost besides; else by the volumes of the points, gaps left out",
    ),
    column("porosity", "-", "void_ratio / (1 + void_ratio)"),
    column(
        "plastic_strain_mean",
        "-",
        "accumulated plastic strain of the points, mean; of cam_clay their plastic compression of volume",
    ),
    column(
        "plastic_strain_max",
        "-",
        "accumulated plastic strain of the points, largest; of cam_clay their plastic compression of volume",
    ),
    column("kinetic_J", "J", "kinetic energy of the points"),
    column("potential_J", "J", "potential energy of the points in gravity"),
    column("stress_work_J", "J", "work of the stresses in the points"),
    column("platen_work_J", "J", "work that the platens have done"),
    column("contact_J", "J", "change since the start of the elastic energy in the contacts of platens, grains and rigid bodies"),
    column(
        "driven_work_J",
        "J",
        "mixture with rigid bodies that are driven, pushed, held or joined: work of all that drives, holds and pushes bodies",
    ),
    column(
        "dissipated_J",
        "J",
        "what was given and neither motion, stresses nor contacts have: damping, transfer, wall friction, errors",
    ),
    column("dissipated_share", "-", "dissipated_J over all energy given"),
    column("momentum_x_kg_m_s", "kg m/s", "momentum along x"),
    column("momentum_y_kg_m_s", "kg m/s", "momentum along y"),
    column("momentum_z_kg_m_s", "kg m/s", "momentum along z"),
    column("grains", "-", "mixture: grains now"),
    column("crush_events", "-", "mixture: breakages so far"),
    column("void_ratio_points", "-", "mixture: pores over solids by the volumes of the points, gaps left out"),
    column("coarse_mass_kg", "kg", "mixture: mass of grains and rigid bodies"),
    column("coarse_kinetic_J", "J", "mixture: kinetic energy of grains and rigid bodies"),
    column("coarse_potential_J", "J", "mixture: their potential energy in gravity"),
    column(
        "coordination_number",
        "-",
        "mixture: twice the contacts between grains over the grains; here and below rigid bodies count as grains, and two that touch at several places have one contact",
    ),
    column("platen_contacts", "-", "mixture: contacts of grains with walls and platens"),
    column("point_contacts", "-", "mixture: contacts of grains and walls with points"),
    column(
        "fabric_xx",
        "-",
        "mixture: fabric tensor of contacts between grains, of bodies at each place where they touch; 0 without contacts",
    ),
    column("fabric_yy", "-", "mixture: the same"),
    column("fabric_zz", "-", "mixture: the same"),
    column("fabric_xy", "-", "mixture: the same"),
    column("fabric_yz", "-", "mixture: the same"),
    column("fabric_zx", "-", "mixture: the same"),
    column("q_matrix_kPa", "kPa", "mixture: deviatoric stress that the points bear"),
    column("q_skeleton_kPa", "kPa", "mixture: that contacts of grains with each other and with platens bear"),
    column("q_interface_kPa", "kPa", "mixture: that contacts of grains with points bear"),
    column("p_matrix_kPa", "kPa", "mixture: mean stress that the points bear"),
    column("p_skeleton_kPa", "kPa", "mixture: that contacts of grains with each other and with platens bear"),
    column("p_interface_kPa", "kPa", "mixture: that contacts of grains with points bear"),
    column("sigma_zz_of_contacts_kPa", "kPa", "mixture: sum of the three shares along z; in balance it is the platens' stress"),
    column("sigma_yy_of_contacts_kPa", "kPa", "mixture in plane strain: the same along y"),
    column("grain_steps", "-", "mixture: steps of the grains in one cycle"),
    column("continuum_steps", "-", "mixture: steps of the continuum in one cycle"),
    column("fines_points", "-", "mixture with crushing.lost_mass = \"points\": points from breakages"),
    column("fines_mass_kg", "kg", "the same: their mass"),
    column("reserve_mass_kg", "kg", "the same: mass that waits for room"),
    column("total_mass_kg", "kg", "the same: mass of all there is"),
    column("released_J", "J", "the same: energy from overlaps that were let go"),
    column("lowest_grain_mm", "mm", "mixture, free scene: lowest point of a grain"),
    column("blocks", "-", "mixture whose rigid bodies break: their number"),
    column(
        "mass_lost_kg",
        "kg",
        "mixture whose grains break: mass that breakages have lost so far, that of fines which became points included",
    ),
    column(
        "d10_mm",
        "mm",
        "the same: size below which 10 % of the mass of the grains and of what they have lost (eq. 12) is, points of the scene not counted; of rigid bodies the edge of the square hole through which they pass",
    ),
    column("d30_mm", "mm", "the same for 30 %"),
    column("d50_mm", "mm", "the same for 50 %: the median"),
    column("d60_mm", "mm", "the same for 60 %"),
    column("cu", "-", "the same: uniformity, d60 / d10"),
    column("cc", "-", "the same: curvature, d30^2 / (d10 d60)"),
    column("hardin_br", "-", "the same: relative breakage of Hardin (1985) of the grains: 0 none"),
    column("einav_br", "-", "the same: relative breakage of Einav (2007) of the grains: 0 none, 1 all"),
    column("einav_beyond", "-", "the same: what their gradation is finer than the ultimate one, over the same area"),
];

const GSD: &[Column] = &[
    column("step", "-", "step of the record"),
    column("stage", "-", "what the test was doing: load, unload, reload, shear, in a mixture settle or load"),
    column("sigma_v_kPa", "kPa", "vertical stress then; empty without a specimen"),
    column("axial_strain", "-", "axial strain then, compression positive"),
    column("diameter_mm", "mm", "sieve, scale taken out"),
    column(
        "passing_percent",
        "%",
        "mass that passes it over all mass of grains and of what they have lost, restored by eq. 12; points of a scene are not counted",
    ),
    column("passing_percent_grains", "%", "the same of the grains alone"),
    column("time_s", "s", "mixture: time then"),
];

const BREAKAGE: &[Column] = &[
    column("event", "-", "number of the breakage, from 1"),
    column("step", "-", "step at which it was; in a mixture of the continuum"),
    column("sigma_v_kPa", "kPa", "vertical stress then; empty without a specimen"),
    column("mother", "-", "number of the grain that broke"),
    column("generation", "-", "her generation: 0 a grain of the start, 1 a daughter of one, …"),
    column("lineage", "-", "her line of descent, on which her strength depends"),
    column(
        "age_steps",
        "-",
        "steps since her own birth, in a mixture those of the grains; of grains of the start steps of the test",
    ),
    column("diameter_mm", "mm", "her diameter"),
    column("force_N", "N", "normal force of the contact that broke her"),
    column("limit_force_N", "N", "force that she could bear there"),
    column("utilisation", "-", "force_N / limit_force_N: how far above her limit she was when she was judged"),
    column(
        "utilisation_before",
        "-",
        "the same a step before, by the way that the two bodies have come since; below 1 (but for a twentieth of the excess): they have collided",
    ),
    column("area_mm2", "mm²", "area on which it acted (eq. 8 or 9)"),
    column("strength_MPa", "MPa", "her limit strength sigma_lim: force over that area, not over the square of the diameter"),
    column("axis_x", "-", "direction of that force"),
    column("axis_y", "-", "the same"),
    column("axis_z", "-", "the same"),
    column("x_mm", "mm", "her centre"),
    column("y_mm", "mm", "the same"),
    column("z_mm", "mm", "the same"),
    column("lost_mass_g", "g", "mass that her daughters do not hold"),
    column("smallest_daughter_mm", "mm", "diameter of the smallest daughter"),
    column("stored_before_J", "J", "elastic energy of the contacts around before"),
    column("stored_after_J", "J", "the same after"),
    column("time_s", "s", "mixture: time at the start of the cycle in which it was"),
];

const CONTACTS: &[Column] = &[
    column("a", "-", "number of the grain that is the first body"),
    column("kind_b", "-", "what the second body is: grain, wall, or point (of a continuum)"),
    column(
        "b",
        "-",
        "number of that grain or point, or name of the wall: bottom, top, cylinder, x_low, …; in a free scene wall_0, wall_1, …",
    ),
    column("x_m", "m", "point of contact: the middle of the overlap, on a wall its surface"),
    column("y_m", "m", "the same"),
    column("z_m", "m", "the same"),
    column("a_x_m", "m", "centre of the first body"),
    column("a_y_m", "m", "the same"),
    column("a_z_m", "m", "the same"),
    column("b_x_m", "m", "centre of the second body; of a wall the point of contact"),
    column("b_y_m", "m", "the same"),
    column("b_z_m", "m", "the same"),
    column("normal_x_N", "N", "normal force on the first body"),
    column("normal_y_N", "N", "the same"),
    column("normal_z_N", "N", "the same"),
    column("tangential_x_N", "N", "tangential force on the first body"),
    column("tangential_y_N", "N", "the same"),
    column("tangential_z_N", "N", "the same"),
    column("overlap_m", "m", "overlap"),
];

const TRACKS: &[Column] = &[
    column("step", "-", "steps since the start"),
    column("time_s", "s", "time"),
    column("grain", "-", "number of the grain, from 0"),
    column("x_m", "m", "centre"),
    column("y_m", "m", "the same"),
    column("z_m", "m", "the same"),
    column("vx_m_s", "m/s", "velocity"),
    column("vy_m_s", "m/s", "the same"),
    column("vz_m_s", "m/s", "the same"),
    column("wx_rad_s", "rad/s", "spin"),
    column("wy_rad_s", "rad/s", "the same"),
    column("wz_rad_s", "rad/s", "the same"),
    column("fx_N", "N", "force of all contacts and gravity"),
    column("fy_N", "N", "the same"),
    column("fz_N", "N", "the same"),
];

const ACCOUNT: &[Column] = &[
    column("step", "-", "steps of the continuum since the start"),
    column("time_s", "s", "time"),
    column("axial_strain", "-", "test: axial strain since the start of loading, compression positive"),
    column("platen_work_J", "J", "given: work of the platens on points and grains, and of moving walls of grains"),
    column("gravity_work_J", "J", "given: loss of potential energy of points and grains"),
    column("released_J", "J", "given: elastic energy of overlaps of points from breakages that bore no force at birth"),
    column(
        "broken_grains_J",
        "J",
        "given: work of softening contacts of broken grains and of growing daughters, and of scaled inertia",
    ),
    column("born_contacts_J", "J", "given: elastic energy with which contacts of daughters and new points begin"),
    column("kinetic_J", "J", "change of kinetic energy of points and grains"),
    column("elastic_points_J", "J", "change of the elastic energy of the stresses of the points"),
    column(
        "elastic_contacts_J",
        "J",
        "change of the elastic energy of contacts: grains and walls, points with grains and walls, platens",
    ),
    column("plastic_work_J", "J", "plastic work of the points"),
    column(
        "volume_J",
        "J",
        "elastic energy per volume times the volume that the points have lost, which the laws of the points do not keep",
    ),
    column("slip_grains_J", "J", "lost in friction between grains and of grains with walls (platens are smooth)"),
    column("slip_points_J", "J", "lost in friction of points with grains and walls of grains"),
    column("viscous_grains_J", "J", "lost in dashpots, or in yielding, of contacts of grains"),
    column("viscous_points_J", "J", "lost in dashpots of contacts of points"),
    column("damping_grains_J", "J", "lost in local damping of the grains"),
    column("damping_nodes_J", "J", "lost in local damping of the nodes"),
    column("transfer_J", "J", "kinetic energy lost between points and nodes, to the nodes and back"),
    column("wall_impact_J", "J", "kinetic energy of nodes that walls of the grid stop"),
    column("wall_friction_J", "J", "lost in friction with walls of the grid"),
    column("ended_contacts_J", "J", "elastic energy of contacts that end with a broken grain or a removed point"),
    column("lost_mass_J", "J", "motion and height of the mass that breakages lose, less what it has as points"),
    column(
        "strain_lag_J",
        "J",
        "work against the stresses on the nodes' mean velocity, less that on the strain of the re-projected velocities",
    ),
    column("gravity_lag_J", "J", "work of gravity on the ways of points, less that on the nodes' mean velocity"),
    column("contact_lag_J", "J", "work of the contacts of points on their path, less what points and grains get from them"),
    column("step_change_J", "J", "work of grains' contacts that falls between two steps of unequal length"),
    column("nonconservative_J", "J", "path work of contacts that is neither stored nor lost: the incremental tangential law"),
    column("account_scale_J", "J", "sum of the magnitudes of what was given, with the motion at the start"),
    column("account_error", "-", "what was given and no term has, over account_scale_J"),
];

const BLOCKS: &[Column] = &[
    column("step", "-", "steps of the continuum since the start"),
    column("time_s", "s", "time"),
    column("block", "-", "number of the rigid body, from 0"),
    column("generation", "-", "where bodies break: breakages between it and the body of the start"),
    column("mass_kg", "kg", "its mass"),
    column("x_m", "m", "its centre"),
    column("y_m", "m", "the same"),
    column("z_m", "m", "the same"),
    column("q_w", "-", "its attitude: quaternion from its own axes to those of the scene"),
    column("q_x", "-", "the same"),
    column("q_y", "-", "the same"),
    column("q_z", "-", "the same"),
    column("vx_m_s", "m/s", "velocity"),
    column("vy_m_s", "m/s", "the same"),
    column("vz_m_s", "m/s", "the same"),
    column("wx_rad_s", "rad/s", "spin"),
    column("wy_rad_s", "rad/s", "the same"),
    column("wz_rad_s", "rad/s", "the same"),
    column("points_x_N", "N", "force of the points on it"),
    column("points_y_N", "N", "the same"),
    column("points_z_N", "N", "the same"),
    column("grains_x_N", "N", "force of the grains on it"),
    column("grains_y_N", "N", "the same"),
    column("grains_z_N", "N", "the same"),
    column("walls_x_N", "N", "force of the walls on it"),
    column("walls_y_N", "N", "the same"),
    column("walls_z_N", "N", "the same"),
    column("blocks_x_N", "N", "force of other rigid bodies on it"),
    column("blocks_y_N", "N", "the same"),
    column("blocks_z_N", "N", "the same"),
    column("joints_x_N", "N", "where bodies are joined: force of joints on it"),
    column("joints_y_N", "N", "the same"),
    column("joints_z_N", "N", "the same"),
    column(
        "outer_x_N",
        "N",
        "where bodies are driven, pushed, held or joined: force of what pushes it; where it is driven or held, of what does so, the opposite of all other forces, without what changes its velocity",
    ),
    column("outer_y_N", "N", "the same"),
    column("outer_z_N", "N", "the same"),
    column("outer_work_J", "J", "work of all that pushes, drives or holds it"),
    column("kinetic_J", "J", "its kinetic energy"),
];

const JOINTS: &[Column] = &[
    column("step", "-", "steps of the continuum since the start"),
    column("time_s", "s", "time"),
    column("joint", "-", "number of the joint, from 0"),
    column("first", "-", "number of the first body"),
    column("second", "-", "number of the second body; -1 for the world"),
    column("fx_N", "N", "force on the second where the joint sits; the first has the opposite"),
    column("fy_N", "N", "the same"),
    column("fz_N", "N", "the same"),
    column("mx_N_m", "N m", "torque on the second besides that of this force; the first has the opposite"),
    column("my_N_m", "N m", "the same"),
    column("mz_N_m", "N m", "the same"),
    column("tension_N", "N", "elastic force along the axis, tension positive"),
    column("shear_N", "N", "elastic force across the axis"),
    column("bending_N_m", "N m", "elastic moment of bending"),
    column("twist_N_m", "N m", "elastic moment of twist"),
    column("utilisation", "-", "larger of the stresses in tension and shear over their strengths; glue breaks at 1"),
    column("broken_at_s", "s", "time at which it broke; -1 while it holds"),
    column("elastic_J", "J", "elastic energy"),
    column("viscous_J", "J", "work that its damping has taken"),
    column("released_J", "J", "elastic energy that went with it when it broke"),
];

const BLOCK_SURFACES: &[Column] = &[
    column("block", "-", "number of the rigid body, from 0; three rows are the corners of a triangle of its surface"),
    column("generation", "-", "where bodies break: breakages between it and the body of the start"),
    column("x_m", "m", "corner, from its centre of mass along its own axes"),
    column("y_m", "m", "the same"),
    column("z_m", "m", "the same"),
];

const BLOCK_BREAKAGE: &[Column] = &[
    column("event", "-", "number of the breakage, from 1"),
    column("step", "-", "step of the bodies in which it happened"),
    column("time_s", "s", "time at the end of the cycle"),
    column("block", "-", "number of the rigid body, which the largest piece keeps"),
    column("piece", "-", "number of the second piece; the others follow by size and number"),
    column("pieces", "-", "number of pieces"),
    column("generation", "-", "breakages between the body and that of the start"),
    column("age_steps", "-", "steps since its birth"),
    column("diameter_mm", "mm", "diameter of the sphere of its volume, in plane strain of the disc of its area"),
    column("force_N", "N", "largest normal force of a partner, all places at which the two touch together"),
    column("limit_force_N", "N", "normal force at which it breaks"),
    column("utilisation", "-", "force over limit force"),
    column("area_mm2", "mm2", "area over which the force makes the stress that is compared with the strength"),
    column("strength_MPa", "MPa", "its limit strength"),
    column("x_mm", "mm", "its centre"),
    column("y_mm", "mm", "the same"),
    column("z_mm", "mm", "the same"),
    column("normal_x", "-", "unit normal of the cut; 0 where there were several"),
    column("normal_y", "-", "the same"),
    column("normal_z", "-", "the same"),
    column("block_mass_g", "g", "mass of the largest piece"),
    column("piece_mass_g", "g", "mass of the second piece"),
    column("lost_volume_mm3", "mm3", "volume that the round edges at the cuts leave to no piece; the mass is theirs"),
    column("stored_J", "J", "elastic energy of the contacts that end with the body"),
    column("lost_kinetic_J", "J", "kinetic energy before less that after"),
];

const WALLS: &[Column] = &[
    column("step", "-", "steps of the continuum since the start"),
    column("time_s", "s", "time"),
    column("wall", "-", "number of the wall, from 0; a box is six: x low, x high, y low, …"),
    column("displacement_mm", "mm", "way along its normal since the start, positive towards the grains"),
    column("speed_m_s", "m/s", "the same: speed"),
    column("force_N", "N", "normal force of grains, points and rigid bodies on it, compression positive"),
    column("work_J", "J", "work of the wall on them since the start"),
];

const SPECIMEN: &[Column] = &[
    column("x_m", "m", "centre"),
    column("y_m", "m", "the same"),
    column("z_m", "m", "the same"),
    column("r_m", "m", "radius"),
    column("generation", "-", "0 a grain of the start, 1 a daughter of one, …"),
    column("material", "-", "name of its material"),
];

const GRAINS_FINAL: &[Column] = &[
    column("x_m", "m", "centre"),
    column("y_m", "m", "the same"),
    column("z_m", "m", "the same"),
    column("r_m", "m", "radius"),
    column("generation", "-", "0 a grain of the start, 1 a daughter of one, …"),
    column("material", "-", "name of its material"),
    column("vx_m_s", "m/s", "velocity"),
    column("vy_m_s", "m/s", "the same"),
    column("vz_m_s", "m/s", "the same"),
    column("wx_rad_s", "rad/s", "spin"),
    column("wy_rad_s", "rad/s", "the same"),
    column("wz_rad_s", "rad/s", "the same"),
];

const POINTS: &[Column] = &[
    column("id", "-", "number of the point"),
    column("x_m", "m", "place"),
    column("y_m", "m", "the same"),
    column("z_m", "m", "the same"),
    column("volume_m3", "m³", "volume it stands for, pores included, gaps left out (in plane strain per metre)"),
    column("plastic_strain", "-", "accumulated plastic strain; of cam_clay the plastic compression of volume"),
    column("p_kPa", "kPa", "mean stress, compression positive"),
    column("q_kPa", "kPa", "deviatoric stress, sqrt(3 J2)"),
    column("vx_m_s", "m/s", "velocity"),
    column("vy_m_s", "m/s", "the same"),
    column("vz_m_s", "m/s", "the same"),
    column("displacement_mm", "mm", "way from its place at the start, in a straight line"),
];

const PLATEN: &[Column] = &[
    column("grain", "-", "number of the grain, from 0"),
    column("diameter_mm", "mm", "its diameter"),
    column("force_N", "N", "force at which it broke, or at the end of the test"),
    column("censored", "-", "1: it did not break"),
    column("displacement_mm", "mm", "way of the platen then"),
    column("strength_MPa", "MPa", "limit strength sigma_lim; force over the square of the diameter is another number"),
    column("limit_force_N", "N", "force that it can bear (eq. 16 or 17)"),
    column("overshoot", "-", "force over limit force, less 1"),
    column("largest_hertz_deviation", "-", "largest relative difference of the force from Hertz's"),
    column("largest_platen_difference", "-", "largest difference of both platens' forces over their mean"),
    column("steps", "-", "steps of the test"),
];

const FORCE_DISPLACEMENT: &[Column] = &[
    column("grain", "-", "number of the grain, from 0"),
    column("diameter_mm", "mm", "its diameter"),
    column("displacement_mm", "mm", "way of the platen"),
    column("force_bottom_N", "N", "force on the lower platen"),
    column("force_top_N", "N", "force on the upper platen"),
    column("force_hertz_N", "N", "Hertz's force at this way"),
];

const SURVIVAL: &[Column] = &[
    column("diameter_from_mm", "mm", "smallest diameter of the class"),
    column("diameter_to_mm", "mm", "largest diameter of the class"),
    column("force_N", "N", "force at which a grain broke"),
    column("survival", "-", "share of grains that bear more (Kaplan & Meier 1958)"),
    column("survival_law", "-", "the same by the strength's law, for a class of one diameter"),
];

const LIMITS: &[Column] = &[
    column("diameter_mm", "mm", "diameter"),
    column("at_mean_strength_N", "N", "limit force of a grain of the mean strength of its size"),
    column("weakest_5_percent_N", "N", "5 % of the grains bear less"),
    column("median_N", "N", "half of the grains bear less"),
    column("strongest_5_percent_N", "N", "5 % of the grains bear more"),
];

const SWEEP: &[Column] = &[
    column("folder", "-", "folder of the run, below that of the sweep"),
    column("status", "-", "done, failed or stopped"),
    column("seed_packing", "-", "seed of the specimen"),
    column("seed_strength", "-", "seed of the strengths"),
    column("crush_events", "-", "breakages"),
    column("grains_final", "-", "grains at the end"),
    column("max_measured_stress_kPa", "kPa", "largest vertical stress"),
    column("porosity_final", "-", "porosity at the end"),
    column("void_ratio_final", "-", "void ratio at the end"),
    column("k0_final", "-", "sigma_h over sigma_v at the end"),
    column("steps", "-", "steps"),
    column("wall_seconds", "s", "time that the run took"),
    column("reason", "-", "why it failed"),
];

const STUDY: &[Column] = &[
    column("setting", "-", "factor and level; the reference first"),
    column("measure", "-", "what is compared"),
    column("seeds", "-", "seeds of which both the setting and the reference are done"),
    column(
        "difference",
        "-",
        "mean over the seeds of the difference from the reference; of a curve the root of the mean square along it",
    ),
    column("half_width", "-", "half the interval of 95 % of that mean, by Student's t"),
    column("tolerance", "-", "largest difference that is allowed"),
    column("verdict", "-", "within, outside, or open where the interval goes across the tolerance"),
    column(
        "run_s",
        "s",
        "mean time of the test, without the preparation of grains: of the processor where a run tells it, else by the clock",
    ),
];

const EFFECTS: &[Column] = &[
    column("effect", "-", "factor and levels; two of them with a cross between for their interaction"),
    column("measure", "-", "what is compared"),
    column("seeds", "-", "seeds of which all runs are done"),
    column(
        "difference",
        "-",
        "mean over the seeds by which the measure changes; of an interaction by how much more than one by one",
    ),
    column("half_width", "-", "half the interval of 95 % of that mean, by Student's t"),
    column("tolerance", "-", "largest difference that is allowed"),
    column("verdict", "-", "within, outside, or open where the interval goes across the tolerance"),
];

const MEAN: &[Column] = &[
    column("stage", "-", "stage of the test"),
    column("sigma_v_kPa", "kPa", "vertical stress at which the runs are compared"),
    column("runs", "-", "runs that are averaged"),
];

const RUNS: &[Column] = &[
    column("run", "-", "folder of the run"),
    column("scene", "-", "name of its scene"),
    column("seed", "-", "seed of the specimen"),
    column("seed_packing", "-", "seed of the specimen"),
    column("seed_strength", "-", "seed of the strengths"),
    column("scale", "-", "scale N of the grains"),
    column("height_mm", "mm", "height of the specimen at the start"),
    column("max_stress_kPa", "kPa", "largest stress asked for"),
    column("points", "-", "material points"),
    column("grains", "-", "grains"),
    column("coarse_mass_fraction", "-", "mass of the grains over that of all solids"),
    column("grains_initial", "-", "grains at the start"),
    column("crush_events", "-", "breakages"),
    column("grains_final", "-", "grains at the end"),
    column("excluded_grains", "-", "further grains that keeping all lost mass would have needed (Ciantia et al. 2015, Table 4)"),
    column("porosity_final", "-", "porosity at the end"),
    column("k0_final", "-", "sigma_h over sigma_v at the end"),
    column("cell_pressure_kPa", "kPa", "cell pressure"),
    column("peak_stress_ratio", "-", "largest sigma_1 over sigma_3"),
    column("peak_axial_strain", "-", "axial strain at it"),
    column("residual_stress_ratio", "-", "mean sigma_1 over sigma_3 at the end"),
    column("mass_error", "-", "mass that was gained or lost by rounding, over all mass"),
    column("dissipated_share", "-", "energy dissipated over all energy given"),
    column("energy_error", "-", "what the energy balance does not account for, over the energy that went through"),
    column("energy_nonconservative", "-", "work of contacts that was neither stored nor lost, over the energy that went through"),
    column("largest_platen_difference", "-", "largest difference of opposite platens' stresses over their mean"),
    column("largest_distance_from_target", "-", "largest difference of the stress from its target over the target"),
    column("largest_inertial_number", "-", "largest inertial number"),
    column("steps", "-", "steps"),
    column("grain_steps", "-", "steps of the grains in one cycle"),
    column("continuum_steps", "-", "steps of the continuum in one cycle"),
    column("user_seconds", "s", "time of all cores"),
    column("wall_seconds", "s", "time that the run took"),
];

/// The whole dictionary as text for a person.
pub fn reference() -> String {
    let mut text = String::from(
        "Columns of the tables that runs leave. Lengths of grains are those of the model: of a scene with specimen.scale they are larger by it,\n\
         except sieves and d10 to d60. Empty: the value does not exist at this row. Figures have tables of their own beside them.\n",
    );
    for sheet in SHEETS {
        text += &format!("\n{} ({})\n", sheet.files, sheet.of);
        let width = sheet.columns.iter().map(|c| c.name.len()).max().unwrap_or(0);
        for Column { name, unit, what } in sheet.columns {
            text += &format!("  {name:<width$}  {unit:<7} {what}\n");
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_stands_once_and_has_the_unit_of_its_name() {
        for sheet in SHEETS {
            for (i, c) in sheet.columns.iter().enumerate() {
                assert!(sheet.columns[..i].iter().all(|other| other.name != c.name), "{} of {}", c.name, sheet.files);
                let units = [
                    ("_kPa", "kPa"),
                    ("_MPa", "MPa"),
                    ("_mm", "mm"),
                    ("_J", "J"),
                    ("_N", "N"),
                    ("_kg", "kg"),
                    ("_N_m", "N m"),
                    ("_m", "m"),
                ];
                if let Some((_, unit)) = units.iter().find(|(suffix, _)| c.name.ends_with(suffix)) {
                    assert_eq!(c.unit, *unit, "{} of {}", c.name, sheet.files);
                }
            }
        }
    }
}
