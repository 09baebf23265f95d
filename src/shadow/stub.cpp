namespace dapple::shadow {}
