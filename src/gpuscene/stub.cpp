namespace dapple::gpuscene {}
