//! Arrays of numpy, which are contiguous here.

use numpy::{IntoPyArray, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use octray::{
    QueryError,
    query::{Ends, Points},
};
use pyo3::{exceptions::PyValueError, prelude::*};

/// Points or vectors, one a row.
#[derive(FromPyObject)]
pub enum Vectors<'py> {
    Single(PyReadonlyArray2<'py, f32>),
    Double(PyReadonlyArray2<'py, f64>),
}

impl Vectors<'_> {
    /// Returns them as rows of three.
    ///
    /// # Errors
    /// `ValueError` if the array is not contiguous.
    pub fn rows(&self) -> PyResult<Points<'_>> {
        let contiguous = |_| PyValueError::new_err("the array is not contiguous");
        Ok(match self {
            Self::Single(array) => Points::F32(array.as_slice().map_err(contiguous)?.as_chunks().0),
            Self::Double(array) => Points::F64(array.as_slice().map_err(contiguous)?.as_chunks().0),
        })
    }
}

/// Ends of rays: one for all, or one per ray.
#[derive(FromPyObject)]
pub enum RayEnds<'py> {
    Each(PyReadonlyArray1<'py, f32>),
    All(f32),
}

impl RayEnds<'_> {
    /// Returns them as the library takes them.
    ///
    /// # Errors
    /// `ValueError` if the array is not contiguous.
    pub fn ends(&self) -> PyResult<Ends<'_>> {
        Ok(match self {
            Self::All(end) => Ends::All(*end),
            Self::Each(array) => Ends::Each(
                array
                    .as_slice()
                    .map_err(|_| PyValueError::new_err("the array is not contiguous"))?,
            ),
        })
    }
}

/// A range of points; a single point is for all rays and stays.
pub fn part<'a>(points: Points<'a>, range: &std::ops::Range<usize>) -> Points<'a> {
    match points {
        _ if points.len() == 1 => points,
        Points::F32(points) => Points::F32(&points[range.clone()]),
        Points::F64(points) => Points::F64(&points[range.clone()]),
    }
}

/// A range of directions or points, one for each answer.
pub fn part_of_all<'a>(points: Points<'a>, range: &std::ops::Range<usize>) -> Points<'a> {
    match points {
        Points::F32(points) => Points::F32(&points[range.clone()]),
        Points::F64(points) => Points::F64(&points[range.clone()]),
    }
}

/// A range of ends.
pub fn part_of_ends<'a>(ends: Ends<'a>, range: &std::ops::Range<usize>) -> Ends<'a> {
    match ends {
        Ends::All(_) => ends,
        Ends::Each(ends) => Ends::Each(&ends[range.clone()]),
    }
}

/// Room for `count` answers.
///
/// # Errors
/// [`QueryError::NoMemory`], for arrays of any size that a caller may ask for.
pub fn room<T>(count: usize) -> Result<Vec<T>, QueryError> {
    let mut room = Vec::new();
    make_room(&mut room, count)?;
    Ok(room)
}

/// Room for `count` more answers.
///
/// # Errors
/// As [`room`].
pub fn make_room<T>(answers: &mut Vec<T>, count: usize) -> Result<(), QueryError> {
    let what = "the results";
    answers
        .try_reserve(count)
        .map_err(|_| QueryError::NoMemory { what })
}

/// An array of rows of `N` numbers.
pub fn rows<'py, T: numpy::Element + Copy, const N: usize>(
    py: Python<'py>,
    rows: Vec<[T; N]>,
) -> PyResult<Bound<'py, PyArray2<T>>> {
    let count = rows.len();
    rows.into_flattened().into_pyarray(py).reshape([count, N])
}
