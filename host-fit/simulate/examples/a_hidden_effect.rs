//! Simulates a case with a known effect: `cargo run -p fos-simulate --example a_hidden_effect [FOLDER]`.

use fos_simulate::{Axis, CasePlan, Effect, Plant, Setup, simulate_case};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut plan = CasePlan::new(7, "bmi270", Setup::Desk, Axis::Gx);
    let effect = Effect::named("thermal_lag").ok_or("no such effect")?;
    plan.planted.push(Plant { effect, parameter: Some(60.0), size: 40.0 });
    let case = simulate_case(&plan)?;
    let planted = &case.truth.planted[0];
    println!(
        "{} of size {:.1} in {}, {:.3} Hz",
        planted.effect, planted.size, case.meta.target, case.truth.rate_hz
    );
    let rows = case.truth.field.error.len();
    assert!(case.field.iter().all(|(_, values)| values.len() == rows), "the truth has a value for every row");
    if let Some(folder) = std::env::args().nth(1) {
        case.write(folder)?;
    }
    Ok(())
}
