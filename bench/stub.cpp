namespace dapple::bench {}
