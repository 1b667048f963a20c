//! The strategies that lead Newton's method to a solution, in the order in which they are tried.
//!
//! Newton's method converges from the right contact zones; a strategy finds these, by a start alone or by a method of its own, from whose
//! result Newton's method goes on. [`StartStrategy::ALL`] is the order for a dense S (the starts without are listed in
//! [`super::newton_krylov`]): each entry says what it does and why it is there, `newton/driver.rs` when it applies, of contact springs
//! `dual/contact_springs.rs`. The loop over them, which runs successive approximations itself, is [`super::solve`].
//!
//! Rigid motions are those of a body that only contact holds, or beside it springs far softer than the body. The rigid compliance is large
//! where a pane moves far more with the body than against its neighbours, or such springs hold the body.

units::worded! {
    /// Where Newton's method begins, or how it comes nearer, in the order in which strategies are tried; [`Self::Relaxed`] moves behind the
    /// interior point where the rigid compliance is large, [`Self::Separated`] behind it where panes slide apart.
    pub enum StartStrategy {
        /// From the face that is separated from its foundation, where no rigid motion that the load drives presses a pane; only this start has all panes
        /// open.
        Separated = "separated",
        /// From the multipliers of a similar problem, on a body whose rigid compliance is large; for other bodies [`Self::Relaxed`] starts there.
        Warm = "warm",
        /// From given multipliers or zero, with sweeps of nonlinear Gauss–Seidel around every step (C. Gräser, R. Kornhuber, *J. Comput.
        /// Math.* 27 (2009) 1): errors of single panes vanish in the sweeps, errors over many panes in the step. Behind
        /// the interior point on bodies with a large rigid compliance, which sweeps cannot move.
        Relaxed = "relaxed",
        /// From the bonded face, λ = S⁻¹h: every pane bonded; those that pull count as open.
        BondedContact = "bonded_contact",
        /// From the face without friction that cannot lift off, λ_ν = S_νν⁻¹h_ν: every pane sliding; those that pull
        /// count as open.
        BilateralFrictionless = "bilateral_frictionless",
        /// By the proximal point method on rigid motions, where there are any (R. T. Rockafellar, *SIAM J. Control Optim.* 14
        /// (1976) 877): panes that open may leave a motion free, and the matrix of Newton's method singular.
        ProximalPoint = "proximal_point",
        /// From points inside the admissible set of a convex problem (S. Mehrotra, *SIAM J. Optim.* 2 (1992) 575): it converges from
        /// anywhere, whatever the condition of S, until rounding ends it.
        InteriorPoint = "interior_point",
        /// With coefficients of friction as unknowns, for coefficients that rise steeply with the slip.
        FrictionGraph = "friction_graph",
        /// By successive approximations (HKL Algorithm 4.1): a fixed point that attracts is found from afar.
        SuccessiveApproximations = "successive_approximations",
        /// With springs between panes and foundation inside A (`dual/contact_springs.rs`), where no solution reaches ε and gaps lose their
        /// digits in S, as those of slender bodies do: from given multipliers or zero, from bonded and from bilateral contact.
        ContactSprings = "contact_springs",
    }
}
