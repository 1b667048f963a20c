//! What the machine has left, and refusals of what does not fit.

use std::path::Path;

use contact3d::{
    dual::{InsufficientResource, Requirement, Resource},
    mesh::brick_counts,
    scene::{Body, Brick, ElementOrder, SceneFile},
};
use studies::accuracy::process_bytes;
use sysinfo::{MemoryRefreshKind, RefreshKind, System};

/// Refuses a step that does not fit into memory, or whose data do not fit on the disk of the run
/// file; what the system does not tell is not checked.
pub(super) fn admit(need: Requirement, run_file: &Path) -> Result<(), InsufficientResource> {
    // A commit copies what stays into a new file beside the old one, and puts it together in memory.
    let kept = std::fs::metadata(run_file).map_or(0, |metadata| metadata.len());
    let stored = need.stored.saturating_add(kept);
    admit_memory(Requirement {
        memory: need.memory.max(need.stored.saturating_add(stored)),
        ..need
    })?;
    let disk = available_disk(run_file);
    require(need.step, Resource::Disk, stored, disk)
}

/// Refuses a step that does not fit into memory.
pub(crate) fn admit_memory(need: Requirement) -> Result<(), InsufficientResource> {
    require(need.step, Resource::Memory, need.memory, available_memory())
}

fn require(
    step: &'static str,
    resource: Resource,
    needed: u64,
    available: Option<u64>,
) -> Result<(), InsufficientResource> {
    match available.filter(|&available| needed > available) {
        None => Ok(()),
        Some(available) => Err(InsufficientResource {
            step,
            resource,
            needed,
            available,
        }),
    }
}

/// Address space that the kernels of dense matrices take for each thread.
const KERNEL_BYTES: u64 = 1 << 26;

/// Bytes the process may take: of the machine, of its control group, of the largest address space.
pub(super) fn available_memory() -> Option<u64> {
    let kinds = MemoryRefreshKind::nothing().with_ram();
    let system = System::new_with_specifics(RefreshKind::nothing().with_memory(kinds));
    // Nothing is told where the files of the system cannot be read, and asking for limits would panic then.
    let told = system.total_memory() > 0;
    let machine = told.then(|| system.available_memory());
    let machine = machine.filter(|bytes| *bytes > 0);
    let groups = std::fs::read_to_string("/proc/self/cgroup").ok();
    let group = groups.and_then(|groups| left_by_groups(&groups, Path::new("/sys/fs/cgroup")));
    let address_space = soft_limit(rlimit::Resource::AS)
        .map(|limit| limit.saturating_sub(process_bytes("VmSize:").unwrap_or(0)))
        .map(|left| left.saturating_sub(KERNEL_BYTES * (rayon::current_num_threads() as u64 + 1)));
    [machine, group, address_space].into_iter().flatten().min()
}

/// Bytes that the control groups of a process leave it, its own and those around it, given `/proc/self/cgroup`.
fn left_by_groups(groups: &str, mount: &Path) -> Option<u64> {
    let left = |line: &str| {
        let [_, controllers, path] = line.splitn(3, ':').collect::<Vec<_>>().try_into().ok()?;
        let (mount, [most, used], cache) = match controllers {
            "" => (
                mount.to_owned(),
                ["memory.max", "memory.current"],
                "inactive_file ",
            ),
            _ if controllers.split(',').any(|word| word == "memory") => (
                mount.join("memory"),
                ["memory.limit_in_bytes", "memory.usage_in_bytes"],
                "total_inactive_file ",
            ),
            _ => return None,
        };
        let left_in = |group: &Path| {
            let text = |file: &str| std::fs::read_to_string(mount.join(group).join(file)).ok();
            let [most, used] = [most, used].map(|file| text(file)?.trim().parse::<u64>().ok());
            // Pages of files that nobody uses go where memory runs short.
            let cache = text("memory.stat").and_then(|stat| {
                let mut lines = stat.lines().filter_map(|line| line.strip_prefix(cache));
                lines.next()?.trim().parse::<u64>().ok()
            });
            Some(most?.saturating_sub(used?.saturating_sub(cache.unwrap_or(0))))
        };
        let path = Path::new(path.trim_start_matches('/'));
        path.ancestors().filter_map(left_in).min()
    };
    groups.lines().filter_map(left).min()
}

/// Bytes that fit into one more file in the folder of the run file.
fn available_disk(run_file: &Path) -> Option<u64> {
    let folder = run_file.parent().filter(|f| !f.as_os_str().is_empty());
    let room = fs4::available_space(folder.unwrap_or(Path::new("."))).ok();
    let largest_file = soft_limit(rlimit::Resource::FSIZE);
    [room, largest_file].into_iter().flatten().min()
}

fn soft_limit(resource: rlimit::Resource) -> Option<u64> {
    let (soft, _) = resource.get().ok()?;
    (soft != rlimit::INFINITY).then_some(soft)
}

/// What making the mesh of a scene takes.
pub(super) fn need_of_mesh(input: &SceneFile) -> Requirement {
    let mut bodies = input.scene.bodies.iter().map(|body| match &body.brick {
        Some(brick) => need_of_counts(brick_counts(brick, body.element), body.element),
        None => need_of_mesh_file(mesh_file_bytes(body, input)),
    });
    let first = bodies.next().unwrap_or_default();
    bodies.fold(first, |sum, body| Requirement {
        memory: sum.memory.saturating_add(body.memory),
        stored: sum.stored.saturating_add(body.stored),
        ..sum
    })
}

/// Bytes of the mesh file of a body; 0 where there is none.
fn mesh_file_bytes(body: &Body, input: &SceneFile) -> u64 {
    let file = body.gmsh.as_ref();
    let file = file.and_then(|gmsh| std::fs::metadata(input.folder.join(&gmsh.file)).ok());
    file.map_or(0, |file| file.len())
}

/// Nodes of the bodies of a scene, as told by its file alone.
fn told_nodes(input: &SceneFile) -> f64 {
    let of_body = |body: &Body| match &body.brick {
        Some(brick) => counted_nodes(brick_counts(brick, body.element)),
        // A node of a Gmsh file and its five tetrahedra take more than a hundred bytes.
        None => mesh_file_bytes(body, input) as f64 / 100.0,
    };
    input.scene.bodies.iter().map(of_body).sum()
}

/// What a mesh of so many nodes, tetrahedra and boundary triangles takes: coordinates, tetrahedra with their regions,
/// the boundary, held components and nodal forces; all there is where they cannot be counted.
fn need_of_counts(counts: Option<[u64; 3]>, element: ElementOrder) -> Requirement {
    let bytes = |per: [u64; 3]| {
        counts?
            .iter()
            .zip(per)
            .try_fold(0_u64, |sum, (count, per)| {
                sum.checked_add(count.checked_mul(per)?)
            })
    };
    let [per_tetrahedron, per_triangle] = match element {
        ElementOrder::P1 => [32, 24],
        ElementOrder::P2 => [80, 48],
    };
    Requirement {
        step: "making the mesh",
        memory: bytes([24 + 3 + 24, per_tetrahedron + 8, per_triangle + 8]).unwrap_or(u64::MAX),
        stored: bytes([24, per_tetrahedron, per_triangle]).unwrap_or(u64::MAX),
        ..Requirement::default()
    }
}

/// What reading a mesh file of so many bytes takes: the file, its nodes and elements as they stand
/// there, and the mesh. Text and binary files of 0.13 and 0.7 million elements took 7.4 to 9 times
/// their size.
pub(super) fn need_of_mesh_file(bytes: u64) -> Requirement {
    Requirement {
        step: "reading the mesh file",
        memory: bytes.saturating_mul(9),
        stored: bytes,
        ..Requirement::default()
    }
}

/// Bytes of memory that assembling and solving a problem with so many nodes takes at most, roughly.
///
/// Peak memory of 41,616, 135,000 and 313,632 unknowns was 217 MB, 870 MB and 2634 MB, 0.8 to 1.0
/// of this.
pub(super) fn problem_bytes(nodes: f64) -> u64 {
    (150.0 * (3.0 * nodes).powf(4.0 / 3.0)) as u64
}

/// Unknowns of the largest problem that fits by [`problem_bytes`].
pub(super) fn unknowns_that_fit() -> usize {
    available_memory().map_or(usize::MAX, |bytes| {
        (bytes as f64 / 150.0).powf(0.75) as usize
    })
}

/// What assembling a brick takes at least: as [`problem_bytes`] of cubes of its shortest edge in a row, of which the factor in single
/// precision takes four tenths; nothing is known of other bodies.
pub(super) fn least_of_problem(input: &SceneFile) -> Requirement {
    let scene = &input.scene;
    let least = scene.as_brick().map(|brick| {
        let nodes = counted_nodes(brick_counts(brick, scene.element()));
        let shortest = brick.cells.iter().min().copied().unwrap_or_default() as f64 + 1.0;
        0.4 * 150.0 * (3.0 * nodes) * (3.0 * shortest.powi(3)).cbrt()
    });
    Requirement {
        step: "assembling the problem",
        memory: least.unwrap_or(0.0) as u64,
        ..Requirement::default()
    }
}

/// Bytes of memory that assembling and solving a scene takes at most, roughly, as told by its file
/// alone.
pub fn scene_bytes(input: &SceneFile) -> u64 {
    problem_bytes(told_nodes(input))
}

/// Nodes of a mesh; infinitely many where they cannot be counted.
fn counted_nodes(counts: Option<[u64; 3]>) -> f64 {
    counts.map_or(f64::INFINITY, |[nodes, ..]| nodes as f64)
}

/// Bytes for the assembled problems of a sweep: three quarters of what is available; no limit where
/// the system does not tell.
pub fn memory_for_sweeps() -> u64 {
    available_memory().map_or(u64::MAX, |bytes| bytes / 4 * 3)
}

/// What the finest mesh of a study takes, of which nothing is stored.
pub(super) fn need_of_finest(brick: &Brick, element: ElementOrder) -> Requirement {
    Requirement {
        step: "solving the finest mesh",
        memory: problem_bytes(counted_nodes(brick_counts(brick, element))),
        ..Requirement::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_fits_passes_and_what_does_not_is_refused_with_both_numbers() {
        let check = |needed, available| require("solving", Resource::Memory, needed, available);
        assert_eq!(check(5, Some(5)), Ok(()));
        assert_eq!(check(u64::MAX, None), Ok(()));
        let refused = check(3_000_000_000, Some(2_000_000_000)).unwrap_err();
        let text = refused.to_string();
        assert!(text.contains("3.0 GB") && text.contains("2.0 GB"), "{text}");
    }

    #[test]
    fn counts_that_overflow_need_more_than_any_machine_has() {
        let brick = Brick::new([1.0; 3], [usize::MAX; 3]);
        let counts = brick_counts(&brick, ElementOrder::P1);
        assert_eq!(need_of_counts(counts, ElementOrder::P1).memory, u64::MAX);
    }

    #[test]
    fn the_tightest_of_nested_control_groups_counts() {
        let mount = tempfile::tempdir().unwrap();
        let group = |path: &str, [most, used, cache]: [u64; 3], [a, b, c]: [&str; 3]| {
            let folder = mount.path().join(path);
            std::fs::create_dir_all(&folder).unwrap();
            std::fs::write(folder.join(a), format!("{most}\n")).unwrap();
            std::fs::write(folder.join(b), format!("{used}\n")).unwrap();
            std::fs::write(folder.join("memory.stat"), format!("anon 1\n{c} {cache}\n")).unwrap();
        };
        let second = ["memory.max", "memory.current", "inactive_file"];
        group("slurm/job", [1000, 400, 100], second);
        group("slurm", [800, 500, 0], second);
        let first = [
            "memory.limit_in_bytes",
            "memory.usage_in_bytes",
            "total_inactive_file",
        ];
        group("memory/job", [250, 50, 0], first);
        let left = |groups: &str| left_by_groups(groups, mount.path());
        assert_eq!(left("0::/slurm/job\n"), Some(300));
        assert_eq!(left("5:cpu,memory:/job/step\n1:cpu:/job\n"), Some(200));
        assert_eq!(left("0::/elsewhere\n"), None);
    }

    /// Peaks of 217 MB, 870 MB and 2634 MB were measured; 200 × 100 × 100 cells are far beyond a machine of 32 GB.
    #[test]
    fn what_a_brick_takes_at_least_is_known_before_it_is_meshed() {
        let least = |cells: [usize; 3]| {
            let text = format!(
                "title = \"t\"\n[body.brick]\nsize = [3.0, 1.0, 1.0]\ncells = {cells:?}\n[material.isotropic]\n\
                 young_modulus = 1e9\npoisson_ratio = 0.3\n[[clamp]]\nface = \"x_min\"\n"
            );
            let scene = SceneFile::parse("scene.toml".into(), &text, ".".into());
            least_of_problem(&scene.unwrap()).memory as f64
        };
        for (n_div, peak) in [(16, 217e6), (24, 870e6), (32, 2634e6)] {
            let least = least([3 * n_div, n_div, n_div]);
            assert!(least < peak && least > 0.2 * peak, "{n_div}: {least:.2e}");
        }
        assert!(least([200, 100, 100]) > 32e9);
    }

    #[test]
    fn this_machine_has_memory_and_disk_space() {
        assert!(available_memory().is_none_or(|bytes| bytes > 0));
        assert!(available_disk(Path::new("run.h5")).is_some_and(|bytes| bytes > 0));
    }
}
