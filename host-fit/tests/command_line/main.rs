//! The program on the command line: each test runs it in a separate folder.

mod calibrate_imu;
mod cli;
mod effect_pictures;
mod empty_axis;
mod escaping;
mod fleet_report;
mod foreign_formats;
mod hostile_numbers;
mod interrupted;
mod logs_of_a_study;
mod missing_effect;
mod noise;
mod own_input;
mod physical_units;
mod random_tables;
mod reference_pages;
mod same_study;
mod session;
mod sources;
mod study_file;
mod subcommands;
mod temperature_tables;
mod tutorials;
mod unusual_files;
mod versions;
