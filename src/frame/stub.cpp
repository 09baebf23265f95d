namespace dapple::frame {}
