//! `sinew ping`: what messages between two ranks take.
use super::fail::Failure;
use super::ranks::Crew;
use sinew::lab::scale::ping::ping;

/// Measure messages between two ranks: mpirun -n 2 sinew ping
///
/// Prints latency, time of a processor for a message, and bandwidth between ranks 0 and 1, for sinew scale --network. Put the two
/// ranks on the machines between which you want to know.
#[derive(clap::Args)]
pub struct Args {
    /// As JSON, in SI units
    #[arg(long)]
    json: bool,
}

/// Runs the subcommand.
pub fn run(args: &Args, crew: Crew) -> Result<(), Failure> {
    let mut network = crew.network;
    if network.size() < 2 {
        return Err(Failure::usage("a ping takes two ranks: mpirun -n 2 sinew ping"));
    }
    let found = ping(&mut *network).map_err(|error| Failure::Local(error.to_string()))?;
    if let Some(ping) = found.filter(|_| network.rank() == 0) {
        match args.json {
            true => println!("{}", serde_json::to_string(&ping).map_err(|e| Failure::Run(e.to_string()))?),
            false => println!(
                "latency        {:.2} us\noverhead       {:.2} us of a processor at each end\nbandwidth      {:.2} GB/s",
                1e6 * ping.latency,
                1e6 * ping.overhead,
                1e-9 * ping.bandwidth
            ),
        }
    }
    network.part(None);
    Ok(())
}
