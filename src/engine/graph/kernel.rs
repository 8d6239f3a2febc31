//! Small tasks, with their bodies beside what they declare.
/// A small task in one piece, in a module of its own: its numbers, what it runs over, what it declares (see
/// [`task!`](crate::task!)), and its body as a function of the task, the place and the views.
///
/// ```
/// mod charges {
///     use engine::prelude::*;
///     labels! {
///         Charge: Wide = particle("C", "q_p");
///         Total: ExactSum = run("C", "sum q_p").exact();
///     }
///     kernel! { /// Q = Σ q_p
///         Add() in add: Particles { requires old { charge: Charge } computes { total: Total } }
///         |_it, at, io| for p in 0..at.count {
///             io.total[0].add(io.charge[p / 8].0[p % 8]);
///         }
///     }
/// }
/// # fn main() {}
/// ```
#[macro_export]
macro_rules! kernel {
    ($(#[doc = $about:literal])+ $task:ident($($of:ty),*) in $module:ident: $domain:ident { $($declared:tt)* }
        |$it:ident, $at:ident, $io:ident| $work:expr) => {
        #[allow(missing_docs)]
        mod $module {
            use super::*;
            $crate::task! {
                $(#[doc = $about])+
                pub struct $task($(pub $of),*);
                $domain task { $($declared)* }
            }
            impl $crate::graph::task::Body for $task {
                #[inline(always)]
                fn run<S: $crate::simd::Simd>(&self, $at: &$crate::graph::task::At<'_>, mut $io: Io<'_>) {
                    let $it = self;
                    $work
                }
            }
        }
    };
}
