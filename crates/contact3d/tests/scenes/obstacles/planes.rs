//! Bricks whose cells shrink towards the contact.

/// n cells between 0 and 1 that shrink towards 0: x_i = sinh(k i/n)/sinh(k).
#[derive(Clone, Copy)]
pub(crate) struct Planes {
    pub(crate) n: usize,
    pub(crate) k: f64,
}

impl Planes {
    fn at(self, i: usize) -> f64 {
        if i == self.n {
            1.0
        } else {
            (self.k * i as f64 / self.n as f64).sinh() / self.k.sinh()
        }
    }

    /// The first plane beyond a place.
    pub(crate) fn beyond(self, x: f64) -> f64 {
        let planes = (0..=self.n).map(|i| self.at(i));
        planes.filter(|at| *at > x).fold(1.0, f64::min)
    }

    fn list(self) -> String {
        let planes: Vec<String> = (0..=self.n).map(|i| format!("{:?}", self.at(i))).collect();
        format!("[{}]", planes.join(", "))
    }

    /// The planes between 0 and 2 that shrink towards 1 from both sides.
    fn both_sides(self) -> String {
        let below = (1..=self.n).rev().map(|i| 1.0 - self.at(i));
        let above = (0..=self.n).map(|i| 1.0 + self.at(i));
        let planes: Vec<String> = below.chain(above).map(|x| format!("{x:?}")).collect();
        format!("[{}]", planes.join(", "))
    }

    /// A quarter of a block around the contact at the origin, of edge 1, or a slice of it that is one cell thick.
    pub(crate) fn quarter(self, slice: Option<f64>) -> String {
        self.brick(1.0, self.n, &self.list(), slice)
    }

    /// Half of a block around the contact at (1, 0, 0), or a slice that is one cell thick.
    pub(crate) fn half(self, slice: Option<f64>) -> String {
        self.brick(2.0, 2 * self.n, &self.both_sides(), slice)
    }

    fn brick(self, length: f64, along: usize, along_x: &str, slice: Option<f64>) -> String {
        let (n, planes) = (self.n, self.list());
        let (width, cells, along_y) = match slice {
            None => (1.0, n, format!("coordinates.y = {planes}\n")),
            Some(width) => (width, 1, String::new()),
        };
        format!(
            "size = [{length:?}, {width:?}, 1.0]\ncells = [{along}, {cells}, {n}]\ncoordinates.x = {along_x}\n{along_y}\
             coordinates.z = {planes}\n"
        )
    }
}
