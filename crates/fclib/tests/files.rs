//! What is written is read again, and what is no problem is refused with its place.

use std::path::{Path, PathBuf};

use contact3d_fclib as fclib;
use fclib::{
    FclibError, FclibSolution, GlobalProblem, Info, LocalProblem, Matrix, declared_bytes,
    program_of, read_global, read_guesses, read_local, read_solution, remove_solution,
    write_global, write_guesses, write_local, write_program, write_solution,
};
use hdf5_metno as hdf5;

fn local() -> LocalProblem {
    LocalProblem {
        space_dimension: 3,
        w: Matrix::from_entries(
            3,
            3,
            vec![
                (0, 0, 2.0),
                (1, 1, 3.0),
                (2, 2, 4.0),
                (0, 2, 0.5),
                (2, 0, 0.5),
            ],
        ),
        q: vec![-1.0, 0.25, 0.0],
        mu: vec![0.5],
        info: Info {
            title: Some("one contact, µ = ½".into()),
            description: None,
            math_info: Some("x".repeat(5000)),
            degrees_of_freedom: Some(6),
        },
    }
}

fn scratch() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("scratch folder");
    let file = folder.path().join("problem.hdf5");
    (folder, file)
}

/// A file to write to, new or as it is.
fn opened(file: &Path) -> hdf5::File {
    hdf5::File::append(file).expect("open")
}

#[test]
fn a_local_problem_comes_back() {
    let (_folder, file) = scratch();
    let problem = local();
    write_local(&opened(&file), &problem).expect("written");
    let read = read_local(&file).expect("read");
    assert_eq!(
        (&read.w, &read.q, &read.mu),
        (&problem.w, &problem.q, &problem.mu)
    );
    assert_eq!(read.info.title, problem.info.title);
    assert_eq!(read.info.degrees_of_freedom, Some(6));
    // A text with the zero at its end has 1024 bytes.
    assert_eq!(read.info.math_info.map(|text| text.len()), Some(1023));
    assert_eq!(read_solution(&file, 3).expect("readable"), None);
    let solution = FclibSolution {
        v: None,
        u: vec![0.0, 0.25, 0.0],
        r: vec![0.5, 0.0, 0.0],
    };
    write_solution(&opened(&file), &solution).expect("written");
    write_guesses(
        &opened(&file),
        &[FclibSolution::default(), solution.clone()].map(|s| FclibSolution {
            u: if s.u.is_empty() { vec![0.0; 3] } else { s.u },
            r: if s.r.is_empty() { vec![0.0; 3] } else { s.r },
            v: None,
        }),
    )
    .expect("written");
    assert_eq!(
        read_solution(&file, 3).expect("readable"),
        Some(solution.clone())
    );
    assert_eq!(read_guesses(&file, 3).expect("readable")[1], solution);
    assert!(read_solution(&file, 6).is_err());
    remove_solution(&opened(&file)).expect("removed");
    assert_eq!(read_solution(&file, 3).expect("readable"), None);
}

#[test]
fn a_global_problem_comes_back_as_triplets() {
    let (_folder, file) = scratch();
    let problem = GlobalProblem {
        space_dimension: 3,
        m: Matrix::from_entries(2, 2, vec![(0, 0, 2.0), (1, 1, 3.0)]),
        h: Matrix::from_entries(2, 3, vec![(1, 0, 1.0), (0, 1, -1.0), (0, 2, 5.0)]),
        f: vec![1.0, 2.0],
        w: vec![0.0, 0.5, 0.0],
        mu: vec![0.5],
        info: Info::default(),
    };
    write_global(&opened(&file), &problem).expect("written");
    assert_eq!(read_global(&file).expect("read"), problem);
    let raw = hdf5::File::open(&file).expect("open");
    let numbers = |name: &str| {
        raw.dataset(name)
            .expect("there")
            .read_raw::<i32>()
            .expect("numbers")
    };
    assert_eq!(numbers("fclib_global/H/nz"), [3]);
    assert_eq!(numbers("fclib_global/H/p"), [0, 1, 2], "columns");
    assert_eq!(numbers("fclib_global/H/i"), [1, 0, 0], "rows");
}

#[test]
fn a_mark_names_the_program() {
    let (_folder, file) = scratch();
    write_local(&opened(&file), &local()).expect("written");
    assert_eq!(program_of(&file), None);
    for _ in 0..2 {
        write_program(&opened(&file), "some program").expect("marked");
        assert_eq!(program_of(&file).as_deref(), Some("some program"));
    }
    assert_eq!(program_of(Path::new("/nowhere")), None);
}

/// Changes one dataset of a written file by unlinking it and writing numbers in its place.
fn changed<T: hdf5::H5Type>(path: &str, values: &[T]) -> FclibError {
    let (_folder, file) = scratch();
    write_local(&opened(&file), &local()).expect("written");
    {
        let raw = hdf5::File::open_rw(&file).expect("open");
        let _ = raw.unlink(path);
        if !values.is_empty() {
            let dataset = raw
                .new_dataset::<T>()
                .shape(values.len())
                .create(path)
                .expect("made");
            dataset.write_raw(values).expect("written");
        }
    }
    read_local(&file).expect_err("refused")
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    let said = |error: FclibError, words: &[&str]| {
        let text = error.to_string();
        for word in words {
            assert!(text.contains(word), "{text}: {word}");
        }
    };
    said(
        changed::<f64>("fclib_local/vectors/q", &[]),
        &["/fclib_local/vectors/q is missing"],
    );
    said(
        changed("fclib_local/vectors/q", &[1.0]),
        &["/fclib_local/vectors/q", "expected 3 numbers, found 1"],
    );
    said(
        changed("fclib_local/vectors/mu", &[1_i32]),
        &["floating-point numbers"],
    );
    said(
        changed("fclib_local/spacedim", &[4_i32]),
        &["2 or 3", "found 4"],
    );
    said(
        changed("fclib_local/W/nz", &[-3_i32]),
        &["/fclib_local/W/nz", "-3"],
    );
    said(
        changed("fclib_local/W/i", &[0_i32, 7, 1, 0, 2]),
        &["sparse matrix"],
    );
    said(
        changed("fclib_local/W/p", &[0_i32, 9, 9, 9]),
        &["sparse matrix"],
    );
    said(changed("fclib_local/W/m", &[2_i32]), &["/fclib_local/W"]);
    said(changed("fclib_local/R/m", &[1_i32]), &["bilateral"]);
    let (_folder, file) = scratch();
    said(read_local(&file).expect_err("no file"), &["problem.hdf5"]);
    hdf5::File::create(&file)
        .expect("made")
        .close()
        .expect("closed");
    said(
        read_local(&file).expect_err("empty"),
        &["/fclib_local is missing"],
    );
}

#[test]
fn all_three_storages_are_one_matrix() {
    let (_folder, file) = scratch();
    let problem = local();
    write_local(&opened(&file), &problem).expect("written");
    let mut entries: Vec<_> = problem.w.entries().collect();
    entries.sort_by_key(|(row, column, _)| (*row, *column));
    let rows: Vec<i32> = vec![0, 2, 3, 5];
    let columns: Vec<i32> = entries
        .iter()
        .map(|(_, column, _)| *column as i32)
        .collect();
    let values: Vec<f64> = entries.iter().map(|(_, _, value)| *value).collect();
    let row_of: Vec<i32> = entries.iter().map(|(row, _, _)| *row as i32).collect();
    let replace = |nz: i32, p: &[i32], i: &[i32]| {
        let raw = hdf5::File::open_rw(&file).expect("open");
        for name in ["nz", "p", "i", "x"] {
            raw.unlink(&format!("fclib_local/W/{name}")).expect("there");
        }
        for (name, values) in [("nz", &[nz][..]), ("p", p), ("i", i)] {
            let dataset = raw.new_dataset::<i32>().shape(values.len());
            dataset
                .create(format!("fclib_local/W/{name}").as_str())
                .expect("made")
                .write_raw(values)
                .expect("written");
        }
        let dataset = raw
            .new_dataset::<f64>()
            .shape(values.len())
            .create("fclib_local/W/x");
        dataset.expect("made").write_raw(&values).expect("written");
    };
    replace(-2, &rows, &columns);
    assert_eq!(read_local(&file).expect("by rows").w, problem.w);
    replace(5, &columns, &row_of);
    assert_eq!(read_local(&file).expect("triplets").w, problem.w);
}

/// Makes a file with a problem whose q is something else; returns why it is refused.
fn refused(make: impl FnOnce(&hdf5::File, &Path)) -> String {
    let (folder, file) = scratch();
    write_local(&opened(&file), &local()).expect("written");
    {
        let raw = hdf5::File::open_rw(&file).expect("open");
        raw.unlink("fclib_local/vectors/q").expect("there");
        make(&raw, folder.path());
    }
    let error = read_local(&file).expect_err("refused").to_string();
    assert!(declared_bytes(&file).is_err(), "{error}");
    error
}

#[test]
fn data_of_other_files_are_not_read() {
    let other = |folder: &Path| {
        let other = folder.join("other.h5");
        let raw = hdf5::File::create(&other).expect("made");
        let secret = raw.new_dataset::<f64>().shape(3).create("secret");
        secret
            .expect("made")
            .write_raw(&[1.0, 2.0, 3.0])
            .expect("written");
        other.to_str().expect("plain").to_owned()
    };
    let link = "/fclib_local/vectors/q: expected data in the file itself, found a link";
    let text = refused(|raw, folder| {
        let target = other(folder);
        raw.link_external(&target, "secret", "fclib_local/vectors/q")
            .expect("linked");
    });
    assert!(text.contains(link), "{text}");
    let text = refused(|raw, _| {
        raw.link_soft("/fclib_local/vectors/mu", "fclib_local/vectors/q")
            .expect("linked");
    });
    assert!(text.contains(link), "{text}");
    let text = refused(|raw, folder| {
        let secret = folder.join("secret");
        std::fs::write(&secret, [0_u8; 24]).expect("written");
        let outside = raw.new_dataset::<f64>().shape(3);
        let outside = outside.external(secret.to_str().expect("plain"), 0, 24);
        outside.create("fclib_local/vectors/q").expect("made");
    });
    assert!(text.contains("found values in other files"), "{text}");
}

/// 2³¹ numbers in a file of some kilobytes, never written and as zeros that deflate made of nothing.
#[test]
fn sizes_without_bytes_behind_them_are_refused() {
    let many = 1_usize << 31;
    let text = refused(|raw, _| {
        let empty = raw.new_dataset::<f64>().shape(many).chunk(1 << 16);
        empty.create("fclib_local/vectors/q").expect("made");
    });
    assert!(text.contains("2147483648"), "{text}");
    let text = changed("fclib_local/W/n", &[i32::MAX]).to_string();
    assert!(text.contains("expected 3 rows and 3 columns"), "{text}");
}
