//! turntable
