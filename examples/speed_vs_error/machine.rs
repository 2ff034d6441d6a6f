//! Where and when the run was made.

use std::process::Command;
use time::OffsetDateTime;

/// "YYYY-MM-DD, CPU, rustc version".
pub(crate) fn describe() -> String {
    let date = OffsetDateTime::now_utc().date();
    let cpus = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = cpus
        .lines()
        .find_map(|line| line.strip_prefix("model name")?.split_once(": "))
        .map_or("unknown processor", |(_, model)| model);
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let compiler = Command::new("rustc").arg("--version").output();
    let compiler = compiler.ok().and_then(|output| String::from_utf8(output.stdout).ok()).unwrap_or_default();
    let mut words = compiler.split_whitespace();
    let compiler =
        format!("{} {}", words.next().unwrap_or("rustc"), words.next().unwrap_or("of unknown version"));
    format!("{date}, one core of {cores} of {model}, {compiler}, release profile")
}
