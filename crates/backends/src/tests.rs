use bendtwin_core::{Category, Problem as _};

use super::*;

fn none() -> Result<Arc<dyn Backend>, engine::Error> {
    Err(engine::Error::Device("no driver: libcuda.so was not found".to_owned()))
}

fn cpu() -> Arc<dyn Backend> {
    engine::cpu_with_threads(1)
}

#[test]
fn auto_falls_back_and_cuda_does_not() {
    let kind = |choice| choose(choice, none, cpu).map(|b| b.device().kind);
    assert_eq!(kind(Choice::Auto).unwrap(), "cpu");
    assert_eq!(kind(Choice::Cpu).unwrap(), "cpu");
    let error = kind(Choice::Cuda).unwrap_err();
    assert_eq!((error.category(), error.reason()), (Category::FailedPrecondition, "NO_CUDA"));
    let text = error.to_string();
    assert!(text.contains("libcuda.so") && !text.contains('\n'), "{text}");
}

#[test]
fn a_library_that_panics_is_one_that_cannot_be_used() {
    let old = || -> Result<Arc<dyn Backend>, engine::Error> { panic!("no such symbol") };
    assert_eq!(choose(Choice::Auto, old, cpu).unwrap().device().kind, "cpu");
    let error = choose(Choice::Cuda, old, cpu).map(drop).unwrap_err();
    assert!(error.to_string().contains("no such symbol"), "{error}");
}

#[test]
fn cuda_is_preferred_and_the_cpu_never_asks_for_it() {
    let unwanted = || -> Arc<dyn Backend> { panic!("the CPU was not asked for") };
    for choice in [Choice::Auto, Choice::Cuda] {
        assert!(choose(choice, || Ok(cpu()), unwanted).is_ok());
    }
    let cuda = || -> Result<Arc<dyn Backend>, engine::Error> { panic!("CUDA was not asked for") };
    assert!(choose(Choice::Cpu, cuda, cpu).is_ok());
}

#[test]
fn a_rasteriser_of_the_cpu_needs_no_device() {
    let options = Options { choice: Choice::Cpu, ..Options::default() };
    assert_eq!(rasteriser(&options).unwrap().name(), "CPU");
}

#[test]
fn names_are_read() {
    for choice in [Choice::Auto, Choice::Cpu, Choice::Cuda] {
        assert_eq!(choice.to_string().parse(), Ok(choice));
    }
    assert!("gpu".parse::<Choice>().unwrap_err().contains("cuda"));
}
