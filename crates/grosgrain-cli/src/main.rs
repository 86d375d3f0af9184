//! The command line.
fn main() {
    for a in std::env::args().skip(1) {
        match grosgrain_cli::scene::read_scene(a.as_ref()) {
            Ok(s) => println!("{s:#?}"),
            Err(e) => println!("{e}"),
        }
    }
}
