//! `sinew graph`: the tasks of a step and what passes between them.
use super::fail::Failure;
use super::run::SceneArgs;
use sinew::grid::{Decomposition, Level};
use sinew::simulation::{rates, step_graph};

/// Output form.
#[derive(Clone, Copy, clap::ValueEnum)]
enum Format {
    /// A table
    Text,
    /// Graphviz
    Dot,
    /// Tasks and edges
    Json,
}

/// Print the task graph of a step of a scene
#[derive(clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// Output form
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    /// Which line of the scene asked for this task?
    #[arg(long, value_name = "TASK")]
    why: Option<String>,
}

/// Runs the subcommand.
pub fn run(args: &Args) -> Result<(), Failure> {
    let scene = args.scene.read()?;
    let level = Level { lower: scene.domain.lower, cell: scene.domain.cell, cells: scene.domain.cells };
    let counts = scene.run.patches.unwrap_or([1; 3]);
    let patches = Decomposition::new(&level, counts).map_err(Failure::usage)?.patches.len();
    let graph = step_graph(&scene, patches).map_err(|error| Failure::Run(error.to_string()))?;
    if let Some(task) = &args.why {
        let found = graph.why(task);
        if found.is_empty() {
            return Err(Failure::usage(format!("no task {task} in this scene; sinew graph lists them")));
        }
        for (name, key) in found {
            let line = scene.lines.iter().find(|(k, _)| !key.is_empty() && k.starts_with(&key));
            match (key.as_str(), line) {
                ("", _) => println!("{name}: every explicit step has it"),
                (_, Some((key, line))) => println!("{name}: {key}, line {line} of the scene"),
                (key, None) => println!("{name}: {key}, by default or by --set"),
            }
        }
        return Ok(());
    }
    let cycle = rates::at_rest(&scene);
    match args.format {
        Format::Text => print!("{}", graph.to_text(&cycle)),
        Format::Dot => print!("{}", graph.to_dot(&cycle)),
        Format::Json => println!("{:#}", graph.to_json(&cycle)),
    }
    Ok(())
}
