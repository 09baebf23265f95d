namespace dapple::gl {}
