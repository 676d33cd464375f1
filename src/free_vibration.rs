//! Free vibration of the nonlinear equation of motion.
